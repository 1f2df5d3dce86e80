cosplat_test(avatar_options
  SOURCES avatar_options_test.cpp ${PROJECT_SOURCE_DIR}/apps/cosplat/avatar_options.cpp
    ${PROJECT_SOURCE_DIR}/apps/cosplat/train_choices.cpp
    ${PROJECT_SOURCE_DIR}/apps/cosplat/train_options.cpp
  LIBRARIES cosplat::avatar cosplat::device cosplat::options CLI11::CLI11)
