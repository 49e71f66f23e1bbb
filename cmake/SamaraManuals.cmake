# Writes the pages for man and the completion of shells as the built command gives them:
#   cmake -DSAMARA=build/apps/samara -DDIRECTORY=.. -P SamaraManuals.cmake
function(answer file)  # answer(<file> <word> ...)
  execute_process(COMMAND ${SAMARA} ${ARGN} OUTPUT_FILE ${DIRECTORY}/${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(MAKE_DIRECTORY ${DIRECTORY}/man1 ${DIRECTORY}/bash ${DIRECTORY}/zsh ${DIRECTORY}/fish)
answer(man1/samara.1 help --man)
answer(bash/samara completion bash)
answer(zsh/_samara completion zsh)
answer(fish/samara.fish completion fish)
execute_process(COMMAND ${SAMARA} help --json OUTPUT_VARIABLE tree COMMAND_ERROR_IS_FATAL ANY)
string(JSON count LENGTH "${tree}" commands)
math(EXPR last "${count} - 1")
foreach(k RANGE ${last})
  string(JSON name GET "${tree}" commands ${k} name)
  answer(man1/samara-${name}.1 help ${name} --man)
endforeach()
