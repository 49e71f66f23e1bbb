# Writes a header with the commit of the sources, where it has changed: cmake -DSOURCE=.. -DHEADER=.. -P SamaraCommit.cmake
# Sources that are no clone may lie in somebody's repository, whose commit is not theirs.
set(commit "")
set(failed FALSE)
if(EXISTS ${SOURCE}/.git)
  execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --exclude=*
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
endif()
if(failed OR NOT commit)
  set(commit "unknown")
endif()
set(text "#pragma once\n\nnamespace samara::apps {\ninline constexpr const char* kCommit = \"${commit}\";\n}\n")
set(before "")
if(EXISTS ${HEADER})
  file(READ ${HEADER} before)
endif()
if(NOT before STREQUAL text)
  file(WRITE ${HEADER} "${text}")
endif()
