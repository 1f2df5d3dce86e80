// Thrown where the page that a module runs in has to do something first (process_web.cpp).
#pragma once

namespace cosplat {

struct PageIsAsked {};

}  // namespace cosplat
