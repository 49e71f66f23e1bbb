# samara_page_parts(<target>): the files that pages for the browser carry (web/, third_party/uplot), as texts in the
# header page_parts.h of the target. Another page is a line here and one in web/parts.h.in.
function(samara_page_parts target)
  set(web ${PROJECT_SOURCE_DIR}/web)
  set(uplot ${PROJECT_SOURCE_DIR}/third_party/uplot)
  set(parts
    uplot_script ${uplot}/uPlot.iife.min.js
    uplot_style ${uplot}/uPlot.min.css
    uplot_licence ${uplot}/LICENSE
    style ${web}/shared/style.css
    kit ${web}/shared/kit.js
    fit_posterior ${web}/fit/posterior.js
    fit_page ${web}/fit/fit_page.js
    patterns_style ${web}/patterns/patterns.css
    patterns_marks ${web}/patterns/marks.js
    patterns_map ${web}/patterns/map.js
    patterns_page ${web}/patterns/patterns_page.js
    motion_page ${web}/motion/motion_page.js
    explorer_markup ${web}/explorer/explorer.html
    explorer_style ${web}/explorer/explorer.css)
  foreach(name evaluate body glb state curves controls view page)
    list(APPEND parts explorer_${name} ${web}/explorer/${name}.js)
  endforeach()
  while(parts)
    list(POP_FRONT parts name file)
    file(READ ${file} SAMARA_PAGE_${name})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endwhile()
  configure_file(${web}/parts.h.in ${CMAKE_CURRENT_BINARY_DIR}/page/page_parts.h @ONLY)
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/page)
endfunction()
