// What parameters of a FLAME model may be: refused by name otherwise.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "flame/model.h"
#include "splat/base/error.h"

namespace cosplat::internal {

// Beyond this a parameter is no pose or coefficient but a fault of the tracker: squared angles and
// scaled directions would leave float's range and come back as NaN.
constexpr double kMaxParameter = 1e6;

template <class Range>
void CheckParameters(const FlameModel& model, const char* name, const Range& values) {
  for (size_t i = 0; i < values.size(); ++i)
    if (!(std::abs(double(values[i])) <= kMaxParameter))
      throw Error(model.name,
                  name + ("[" + std::to_string(i) + "]"),
                  std::to_string(double(values[i])) + " is not a usable number");
}

// Number of coefficients that the model can use; the excess must be zero.
template <class T>
size_t CheckCoefficients(const FlameModel& model,
                         const char* name,
                         const std::vector<T>& values,
                         int available) {
  CheckParameters(model, name, values);
  for (size_t i = available; i < values.size(); ++i)
    if (values[i] != T(0))
      throw Error(model.name,
                  name + ("[" + std::to_string(i) + "]"),
                  "is " + std::to_string(double(values[i])) + ", but the model has only " +
                      std::to_string(available) + " directions");
  return std::min(values.size(), size_t(available));
}

}  // namespace cosplat::internal
