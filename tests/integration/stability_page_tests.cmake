set(apps ${PROJECT_SOURCE_DIR}/apps/cosplat)
cosplat_test(stability_page
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/stability_page_test.cpp
    ${apps}/chart_scale.cpp
    ${apps}/data_uri.cpp
    ${apps}/stability_page.cpp
    ${apps}/svg_chart.cpp
    ${apps}/svg_drawing.cpp
  LIBRARIES cosplat::study)
