# The page of `strake report`: page/src with the libraries of package-lock.json, bundled and embedded in the library.
# Node and npm are needed only to build Strake. If they or npm's packages are missing, Strake is built without the page
# and `strake report` says what is missing; -DSTRAKE_REPORT_PAGE=ON makes that an error.
set(STRAKE_REPORT_PAGE AUTO CACHE STRING "the page of strake report: AUTO (if node and npm are available), ON or OFF")
if(STRAKE_REPORT_PAGE STREQUAL "OFF")
  return()
endif()

set(page ${CMAKE_CURRENT_SOURCE_DIR}/page)
set(built ${CMAKE_CURRENT_BINARY_DIR}/page)
find_program(STRAKE_PAGE_NODE NAMES node nodejs)
find_program(STRAKE_PAGE_NPM npm)
mark_as_advanced(STRAKE_PAGE_NODE STRAKE_PAGE_NPM)

function(strake_no_page why)
  set(level WARNING)
  if(STRAKE_REPORT_PAGE STREQUAL "ON")
    set(level FATAL_ERROR)
  endif()
  message(${level} "`strake report` is built without its page: ${why}. Everything else works. With the page: "
    "scripts/setup.sh run, then configure again; -DSTRAKE_REPORT_PAGE=OFF silences this.")
endfunction()

# A source package brings the finished bundle (package.sh): nothing is fetched.
if(EXISTS ${page}/bundle/main.js AND EXISTS ${page}/bundle/main.css)
  set_source_files_properties(report_page.cpp PROPERTIES OBJECT_DEPENDS "${page}/bundle/main.js;${page}/bundle/main.css")
  target_compile_definitions(strake_report PRIVATE STRAKE_PAGE_SCRIPT="${page}/bundle/main.js" STRAKE_PAGE_STYLE="${page}/bundle/main.css")
  return()
endif()

if(NOT STRAKE_PAGE_NODE OR NOT STRAKE_PAGE_NPM)
  strake_no_page("node or npm was not found")
  return()
endif()

# Once for each change of the lock file. No package scripts are run.
file(SHA256 ${page}/package-lock.json locked)
set(fetched "")
if(EXISTS ${built}/fetched)
  file(READ ${built}/fetched fetched)
endif()
if(NOT fetched STREQUAL locked)
  message(STATUS "Fetching the libraries of the report's page by npm")
  file(COPY ${page}/package.json ${page}/package-lock.json DESTINATION ${built})
  execute_process(
    COMMAND ${STRAKE_PAGE_NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error
    WORKING_DIRECTORY ${built} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said TIMEOUT 120)
  if(NOT status EQUAL 0)
    string(STRIP "${said}" said)
    string(SUBSTRING "${said}" 0 400 said)
    strake_no_page("npm could not fetch its packages (${status}): ${said}")
    return()
  endif()
  file(WRITE ${built}/fetched ${locked})
endif()
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${page}/package-lock.json)

file(GLOB sources CONFIGURE_DEPENDS ${page}/src/*.js ${page}/src/*.css)
add_custom_command(OUTPUT ${built}/main.js ${built}/main.css
  COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${built}/node_modules ${STRAKE_PAGE_NODE} ${built}/node_modules/esbuild/bin/esbuild
          ${page}/src/main.js --bundle --minify --format=iife --target=es2022 --charset=utf8 --legal-comments=inline --log-level=warning
          --outfile=${built}/main.js
  DEPENDS ${sources} ${built}/fetched
  COMMENT "Bundling the page of strake report")
# By itself for package.sh: as a part of strake_report alone it would wait for all libraries below.
add_custom_target(strake_page DEPENDS ${built}/main.js ${built}/main.css)
add_dependencies(strake_report strake_page)
set_source_files_properties(report_page.cpp PROPERTIES OBJECT_DEPENDS "${built}/main.js;${built}/main.css")
target_compile_definitions(strake_report PRIVATE STRAKE_PAGE_SCRIPT="${built}/main.js" STRAKE_PAGE_STYLE="${built}/main.css")
