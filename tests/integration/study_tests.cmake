set(apps ${PROJECT_SOURCE_DIR}/apps/cosplat)
cosplat_test(study_parts
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/study_list_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/study_parts_test.cpp
    ${apps}/chart_scale.cpp
    ${apps}/progress_bar.cpp
    ${apps}/study_charts.cpp
    ${apps}/study_figures.cpp
    ${apps}/study_lines.cpp
    ${apps}/study_list.cpp
    ${apps}/study_page.cpp
    ${apps}/study_statistics.cpp
    ${apps}/svg_chart.cpp
    ${apps}/svg_drawing.cpp
  LIBRARIES cosplat::base)

add_executable(cosplat_test_study_command ${CMAKE_CURRENT_LIST_DIR}/study_test.cpp)
target_link_libraries(cosplat_test_study_command PRIVATE
  cosplat::base cosplat::options GTest::gtest_main)
target_compile_definitions(cosplat_test_study_command PRIVATE
  COSPLAT_COMMAND="$<TARGET_FILE:cosplat>")
add_dependencies(cosplat_test_study_command cosplat)
add_test(NAME study COMMAND cosplat_test_study_command)
