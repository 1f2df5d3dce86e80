# oneDNN (libdnnl-dev) runs networks, ONNX's own library (libonnx-dev, on libprotobuf-dev) reads their
# files. oneDNN's CMake config asks for OpenCL's headers and ONNX's for protobuf's compiler, of which
# nothing here is used; hence this module, which makes the imported targets dnnl and onnx_proto.
find_package(OpenMP QUIET COMPONENTS CXX)  # oneDNN's threads; sets how many there are
find_path(DNNL_INCLUDE_DIR dnnl.hpp)
find_library(DNNL_LIBRARY dnnl)
find_path(ONNX_INCLUDE_DIR onnx/onnx_pb.h)
find_library(ONNX_LIBRARY onnx_proto)
find_path(PROTOBUF_INCLUDE_DIR google/protobuf/message.h)
find_library(PROTOBUF_LIBRARY protobuf)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Networks REQUIRED_VARS
  DNNL_LIBRARY DNNL_INCLUDE_DIR ONNX_LIBRARY ONNX_INCLUDE_DIR PROTOBUF_LIBRARY PROTOBUF_INCLUDE_DIR
  OpenMP_CXX_FOUND)
if(Networks_FOUND AND NOT TARGET dnnl)
  add_library(dnnl UNKNOWN IMPORTED)
  set_target_properties(dnnl PROPERTIES
    IMPORTED_LOCATION "${DNNL_LIBRARY}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${DNNL_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES OpenMP::OpenMP_CXX)
  add_library(onnx_proto UNKNOWN IMPORTED)
  set_target_properties(onnx_proto PROPERTIES
    IMPORTED_LOCATION "${ONNX_LIBRARY}"
    INTERFACE_COMPILE_DEFINITIONS "ONNX_NAMESPACE=onnx;ONNX_ML=1"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${ONNX_INCLUDE_DIR};${PROTOBUF_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${PROTOBUF_LIBRARY}")
endif()
mark_as_advanced(DNNL_LIBRARY DNNL_INCLUDE_DIR ONNX_LIBRARY ONNX_INCLUDE_DIR PROTOBUF_LIBRARY
  PROTOBUF_INCLUDE_DIR)
