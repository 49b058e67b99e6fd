# The pages of `strake report` and `strake studio`: their sources with what they share (page/src) and the libraries of
# package-lock.json, bundled and embedded in the program. Node and npm are needed only to build Strake. If they or npm's packages
# are missing, Strake is built without the pages and both commands say what is missing; -DSTRAKE_REPORT_PAGE=ON makes that an error.
set(STRAKE_REPORT_PAGE AUTO CACHE STRING "the pages of strake report and strake studio: AUTO (if node and npm are available), ON or OFF")
set(strake_pages report studio)
set(strake_page_folder "" CACHE INTERNAL "where the finished pages are; empty: there are none")
set(page ${CMAKE_CURRENT_SOURCE_DIR}/page)
set(built ${CMAKE_CURRENT_BINARY_DIR}/page)

# Embeds the page `name` in `source` of `target`, which includes STRAKE_PAGE_SCRIPT and STRAKE_PAGE_STYLE.
function(strake_bundle_page name target source)
  if(NOT strake_page_folder)
    return()
  endif()
  if(TARGET strake_pages)
    add_dependencies(${target} strake_pages)
  endif()
  set(files ${strake_page_folder}/${name}.js ${strake_page_folder}/${name}.css)
  set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS "${files}" COMPILE_DEFINITIONS
    "STRAKE_PAGE_SCRIPT=\"${strake_page_folder}/${name}.js\";STRAKE_PAGE_STYLE=\"${strake_page_folder}/${name}.css\"")
endfunction()

if(STRAKE_REPORT_PAGE STREQUAL "OFF")
  return()
endif()
find_program(STRAKE_PAGE_NODE NAMES node nodejs)
find_program(STRAKE_PAGE_NPM npm)
mark_as_advanced(STRAKE_PAGE_NODE STRAKE_PAGE_NPM)

function(strake_no_page why)
  set(level WARNING)
  if(STRAKE_REPORT_PAGE STREQUAL "ON")
    set(level FATAL_ERROR)
  endif()
  message(${level} "`strake report` and `strake studio` are built without their pages: ${why}. Everything else works. With them: "
    "scripts/setup.sh run, then configure again; -DSTRAKE_REPORT_PAGE=OFF silences this.")
endfunction()

# A source package brings the finished bundles (package.sh): nothing is fetched.
if(EXISTS ${page}/bundle/report.js AND EXISTS ${page}/bundle/studio.js)
  set(strake_page_folder ${page}/bundle CACHE INTERNAL "")
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
  message(STATUS "Fetching the libraries of the pages by npm")
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

file(GLOB shared CONFIGURE_DEPENDS ${page}/src/*.js ${page}/src/*.css)
set(bundles)
foreach(name ${strake_pages})
  set(src ${PROJECT_SOURCE_DIR}/${name}/page/src)
  file(GLOB own CONFIGURE_DEPENDS ${src}/*.js ${src}/*.css)
  add_custom_command(OUTPUT ${built}/${name}.js ${built}/${name}.css
    COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${built}/node_modules ${STRAKE_PAGE_NODE} ${built}/node_modules/esbuild/bin/esbuild
            ${src}/main.js --bundle --minify --format=iife --target=es2022 --charset=utf8 --legal-comments=inline --log-level=warning
            --outfile=${built}/${name}.js
    DEPENDS ${own} ${shared} ${built}/fetched
    COMMENT "Bundling the page of strake ${name}")
  list(APPEND bundles ${built}/${name}.js ${built}/${name}.css)
endforeach()
# By itself for package.sh: as a part of a library alone it would wait for all libraries below.
add_custom_target(strake_pages ALL DEPENDS ${bundles})
set(strake_page_folder ${built} CACHE INTERNAL "")
