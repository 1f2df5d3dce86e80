// The implementations of header-only libraries, and the one function of splat/base's images that is
// reached in the page: recordings may name images, which are not read there.
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
