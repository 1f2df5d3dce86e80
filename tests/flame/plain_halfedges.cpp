// In this folder's build under its own name (CMakeLists.txt gives the file itself another one).
#include "flame/halfedges_plain.cpp"  // NOLINT
