# Writes OUTPUT from version.cpp.in: VERSION, or if that is empty what setuptools_scm says of ROOT, run by PYTHON.
if(NOT VERSION)
  execute_process(COMMAND ${PYTHON} -W ignore -m setuptools_scm WORKING_DIRECTORY ${ROOT}
    OUTPUT_VARIABLE VERSION ERROR_VARIABLE problem RESULT_VARIABLE status OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "No version from `${PYTHON} -m setuptools_scm` in ${ROOT} "
      "(make build installs setuptools_scm; scripts/requirements/run.txt):\n${problem}")
  endif()
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/version.cpp.in ${OUTPUT} @ONLY)
