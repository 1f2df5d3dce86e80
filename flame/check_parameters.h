// Validation of FLAME parameters; throws Error naming the offending one.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "flame/model.h"
#include "splat/base/error.h"

namespace cosplat::internal {

// Larger parameters are tracking failures, not poses or coefficients: their squared angles and
// scaled directions would overflow float and produce NaN.
constexpr double kMaxParameter = 1e6;

template <class Range>
void CheckParameters(const FlameModel& model, const char* name, const Range& values) {
  for (size_t i = 0; i < values.size(); ++i)
    if (!(std::abs(double(values[i])) <= kMaxParameter))
      throw Error(model.name,
                  name + ("[" + std::to_string(i) + "]"),
                  std::to_string(double(values[i])) + " is not a finite number within [-1e6, 1e6]");
}

// Returns how many coefficients the model can use; any excess ones must be zero.
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
