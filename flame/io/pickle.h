// Reads Python pickles as data, without executing anything in them.
//
// FLAME's own model files and trackers' checkpoints are pickles, which Python executes as programs
// when it loads them. This reader interprets only the opcodes of protocols 0 to 4 that build plain
// data, and represents objects of a fixed list of classes (numpy arrays, scipy's csc_matrix,
// chumpy's wrappers, torch's tensors) by their class and state. Any other class, and every opcode
// that could construct something else, is an Error that names it. Opcodes: CPython's
// Lib/pickletools.py.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "splat/base/npz.h"

namespace cosplat {

enum class PickleClass {
  kArrayReconstruct,  // numpy.core.multiarray._reconstruct: makes a kArray
  kArray,             // numpy.ndarray; state (version, shape, dtype, is_fortran, bytes)
  kDtype,             // numpy.dtype; arguments (name, ...), state (version, byte order, ...)
  kScalar,            // numpy.core.multiarray.scalar; arguments (dtype, bytes)
  kCscMatrix,         // scipy's csc_matrix; state {_shape, indices, indptr, data}
  kChumpy,            // chumpy.ch.Ch; state {x}
  kChumpySelect,      // chumpy.reordering.Select; state {a, idxs, preferred_shape}
  kEncode,            // _codecs.encode: text to bytes
  kReconstructor,     // copy_reg._reconstructor: makes an object of its first argument
  kObject,            // __builtin__.object, the base class named there
  kOrderedDict,       // collections.OrderedDict, kept as a plain dictionary
  kTensor,            // torch._utils._rebuild_tensor_v2; arguments (storage, offset, size, stride,
                      // requires_grad, hooks), offset and strides in numbers
  kTensorParameter,   // torch._utils._rebuild_parameter; arguments (tensor, requires_grad, hooks)
  kStorageType,       // torch's FloatStorage and its like; `text`: numpy's name of the numbers
  kStorage,           // what a persistent identifier refers to; arguments (storage type, number
                      // of numbers), `text`: the bytes
};

struct PickleValue {
  enum class Kind {
    kNone,
    kBool,
    kInteger,
    kFloat,
    kText,
    kBytes,
    kList,
    kTuple,
    kDict,
    kClass,
    kObject
  };
  Kind kind = Kind::kNone;
  int64_t integer = 0;  // kBool, kInteger
  double real = 0;      // kFloat
  std::string text;     // kText: UTF-8, or the bytes of a Python-2 string; kBytes; of torch's types
  // kList, kTuple: the items; kDict: alternating keys and values; kObject: constructor arguments.
  std::vector<const PickleValue*> items;
  PickleClass type = PickleClass::kObject;  // kClass, kObject
  const PickleValue* state = nullptr;       // kObject: state set by BUILD, or null

  // The value of a text key of a kDict (the last one, as in Python), or null.
  const PickleValue* Find(const std::string& key) const;
};

// A parsed pickle, which owns its values. Values may contain reference cycles.
class Pickle {
 public:
  // The bytes of the storage with this name; throws Error if there is none.
  using ReadStorage = std::function<std::vector<char>(const std::string& name)>;

  // `read_storage` is called once per storage that the pickle refers to; without it, a reference is
  // an error. Throws Error(file, "byte N", ...) unless the pickle is complete and acceptable.
  // Memory use is bounded by the length of `bytes` and of the storages.
  Pickle(const std::string& file,
         const std::vector<char>& bytes,
         const ReadStorage& read_storage = nullptr);
  Pickle(const Pickle&) = delete;
  Pickle& operator=(const Pickle&) = delete;
  const PickleValue& root() const { return *root_; }

 private:
  std::deque<PickleValue> values_;
  const PickleValue* root_ = nullptr;
};

// The pickle in a checkpoint of PyTorch's (torch.save since 1.6): a ZIP archive that holds it as
// NAME/data.pkl, and the bytes of each tensor's storage as NAME/data/KEY. Throws Error naming the
// file and the member if it is no such archive, if its numbers are stored big-endian, or if the
// pickle is refused.
Pickle ReadTorchFile(const std::string& path);

// Conversion of a parsed pickle's values to numeric arrays: numpy arrays and scalars, numbers,
// torch's tensors, scipy's csc_matrix (made dense) and chumpy's wrappers around any of them.

// `file` and `name` are for errors. Throws Error if `value` is not a numeric array, or if its
// shape, type and data are inconsistent.
NpyArray ArrayOf(const std::string& file, const std::string& name, const PickleValue& value);

}  // namespace cosplat
