#include "flame/io/pickle.h"

#include <array>
#include <utility>

#include "flame/io/pickle_machine.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

using Kind = PickleValue::Kind;

// numpy's, scipy's and chumpy's constructors take at most three arguments, a tensor's seven.
constexpr size_t kMaxArguments = 4, kMaxTensorArguments = 7;

struct AcceptedClass {
  const char* module;
  const char* name;
  PickleClass type;
  const char* dtype = "";  // kStorageType
};

// All names that a pickle may refer to. Module names changed over the years.
constexpr std::array kAcceptedClasses = {
    AcceptedClass{"numpy.core.multiarray", "_reconstruct", PickleClass::kArrayReconstruct},
    AcceptedClass{"numpy._core.multiarray", "_reconstruct", PickleClass::kArrayReconstruct},
    AcceptedClass{"numpy.core.multiarray", "scalar", PickleClass::kScalar},
    AcceptedClass{"numpy._core.multiarray", "scalar", PickleClass::kScalar},
    AcceptedClass{"numpy", "ndarray", PickleClass::kArray},
    AcceptedClass{"numpy", "dtype", PickleClass::kDtype},
    AcceptedClass{"scipy.sparse.csc", "csc_matrix", PickleClass::kCscMatrix},
    AcceptedClass{"scipy.sparse._csc", "csc_matrix", PickleClass::kCscMatrix},
    AcceptedClass{"chumpy.ch", "Ch", PickleClass::kChumpy},
    AcceptedClass{"chumpy.reordering", "Select", PickleClass::kChumpySelect},
    AcceptedClass{"_codecs", "encode", PickleClass::kEncode},
    AcceptedClass{"copy_reg", "_reconstructor", PickleClass::kReconstructor},
    AcceptedClass{"copyreg", "_reconstructor", PickleClass::kReconstructor},
    AcceptedClass{"__builtin__", "object", PickleClass::kObject},
    AcceptedClass{"builtins", "object", PickleClass::kObject},
    AcceptedClass{"collections", "OrderedDict", PickleClass::kOrderedDict},
    AcceptedClass{"torch._utils", "_rebuild_tensor_v2", PickleClass::kTensor},
    AcceptedClass{"torch._utils", "_rebuild_parameter", PickleClass::kTensorParameter},
    AcceptedClass{"torch", "HalfStorage", PickleClass::kStorageType, "<f2"},
    AcceptedClass{"torch", "FloatStorage", PickleClass::kStorageType, "<f4"},
    AcceptedClass{"torch", "DoubleStorage", PickleClass::kStorageType, "<f8"},
    AcceptedClass{"torch", "IntStorage", PickleClass::kStorageType, "<i4"},
    AcceptedClass{"torch", "LongStorage", PickleClass::kStorageType, "<i8"},
};

// Names from a file, made fit for a one-line message.
std::string Printable(std::string_view text) {
  std::string out;
  for (char c : text.substr(0, 60)) out += c >= ' ' && c < 127 ? c : '?';
  return text.size() > 60 ? out + "..." : out;
}

constexpr std::pair<uint8_t, const char*> kRefusedOpcodes[] = {{'i', "INST"},
                                                               {'o', "OBJ"},
                                                               {'P', "PERSID"},
                                                               {0x82, "EXT1"},
                                                               {0x83, "EXT2"},
                                                               {0x84, "EXT4"},
                                                               {0x8f, "EMPTY_SET"},
                                                               {0x90, "ADDITEMS"},
                                                               {0x91, "FROZENSET"},
                                                               {0x92, "NEWOBJ_EX"},
                                                               {0x96, "BYTEARRAY8"},
                                                               {0x97, "NEXT_BUFFER"},
                                                               {0x98, "READONLY_BUFFER"}};

std::string NameOfRefusedOpcode(uint8_t opcode) {
  for (const auto& [refused, name] : kRefusedOpcodes)
    if (refused == opcode) return name;
  return Format("0x{:02x}", opcode);
}

}  // namespace

const PickleValue* PickleMachine::Run() {
  for (;;) {
    in_.BeginOpcode();
    const uint8_t opcode = uint8_t(in_.Unsigned(1));
    if (opcode == '.') return Pop();
    if (!Constant(opcode) && !Text(opcode) && !Container(opcode) && !Stack(opcode) &&
        !Object(opcode))
      in_.Fail("opcode " + NameOfRefusedOpcode(opcode) +
               " is not accepted (nothing in a pickle is executed here)");
  }
}

bool PickleMachine::PushClass(std::string_view module, std::string_view name) {
  for (const AcceptedClass& c : kAcceptedClasses) {
    if (module != c.module || name != c.name) continue;
    PickleValue* value = New(Kind::kClass);
    value->type = c.type;
    value->text = c.dtype;
    return Push(value);
  }
  in_.Fail("class " + Printable(module) + "." + Printable(name) +
           " is not accepted (nothing in a pickle is executed here)");
}

bool PickleMachine::Object(uint8_t opcode) {
  switch (opcode) {
    case 'c': {
      const std::string_view module = in_.Line();
      return PushClass(module, in_.Line());
    }
    case 0x93: {
      const PickleValue* name = Pop();
      const PickleValue* module = Pop();
      if (name->kind != Kind::kText || module->kind != Kind::kText)
        in_.Fail("STACK_GLOBAL without the name of a class");
      return PushClass(module->text, name->text);
    }
    case 'R':
      return Call();
    case 0x81: {
      const PickleValue* arguments = Pop();
      return Construct(Pop(), arguments);
    }
    case 'Q':
      return PushStorage(Pop());
    case 'b': {
      const PickleValue* state = Pop();
      PickleValue* object = Top();
      if (object->kind != Kind::kObject) in_.Fail("BUILD on what is no object");
      object->state = state;
      return true;
    }
    default:
      return false;
  }
}

// REDUCE: the few callables that represent data.
bool PickleMachine::Call() {
  const PickleValue* arguments = Pop();
  const PickleValue* callable = Pop();
  if (callable->kind != Kind::kClass || arguments->kind != Kind::kTuple)
    in_.Fail("REDUCE of what is no class");
  const auto& items = arguments->items;
  switch (callable->type) {
    case PickleClass::kArrayReconstruct:
    case PickleClass::kReconstructor:
      if (items.empty()) in_.Fail("a constructor without the name of its class");
      return Construct(items[0], arguments);
    case PickleClass::kEncode:
      if (items.empty() || items.size() > 2 || items[0]->kind != Kind::kText ||
          (items.size() == 2 && items[1]->text != "latin1"))
        in_.Fail("_codecs.encode of anything but text to latin1");
      return PushText(Kind::kBytes, in_.Latin1Bytes(items[0]->text));
    default:
      return Construct(callable, arguments);
  }
}

bool PickleMachine::Construct(const PickleValue* type, const PickleValue* arguments) {
  if (type->kind != Kind::kClass || arguments->kind != Kind::kTuple)
    in_.Fail("an object without a class");
  if (arguments->items.size() >
      (type->type == PickleClass::kTensor ? kMaxTensorArguments : kMaxArguments))
    in_.Fail("a constructor with " + std::to_string(arguments->items.size()) + " arguments");
  switch (type->type) {
    case PickleClass::kArray:
    case PickleClass::kDtype:
    case PickleClass::kScalar:
    case PickleClass::kCscMatrix:
    case PickleClass::kChumpy:
    case PickleClass::kChumpySelect:
    case PickleClass::kTensor:
    case PickleClass::kTensorParameter: {
      PickleValue* object = New(Kind::kObject);
      object->type = type->type;
      object->items = arguments->items;
      return Push(object);
    }
    case PickleClass::kOrderedDict:
      if (!arguments->items.empty()) in_.Fail("collections.OrderedDict with arguments");
      return Push(New(Kind::kDict));
    default:
      in_.Fail("an object of a class that is only a function");
  }
}

// BINPERSID: ("storage", storage type, name, device, count). A storage that tensors share is kept
// once.
bool PickleMachine::PushStorage(const PickleValue* identifier) {
  const auto& items = identifier->items;
  if (!read_storage_) in_.Fail("a persistent identifier, in a file that has no storages");
  if (identifier->kind != Kind::kTuple || items.size() != 5 || items[0]->text != "storage" ||
      items[1]->kind != Kind::kClass || items[1]->type != PickleClass::kStorageType ||
      items[2]->kind != Kind::kText || items[4]->kind != Kind::kInteger)
    in_.Fail("a persistent identifier that is no storage of torch's");
  PickleValue*& storage = storages_[items[2]->text];
  if (storage == nullptr) {
    const std::vector<char> bytes = read_storage_(items[2]->text);
    storage = New(Kind::kObject);
    storage->type = PickleClass::kStorage;
    storage->items = {items[1], items[4]};
    storage->text.assign(bytes.begin(), bytes.end());
  }
  return Push(storage);
}

const PickleValue* PickleValue::Find(const std::string& key) const {
  if (kind != Kind::kDict) return nullptr;
  for (size_t i = items.size(); i >= 2; i -= 2) {
    const PickleValue* k = items[i - 2];
    if ((k->kind == Kind::kText || k->kind == Kind::kBytes) && k->text == key) return items[i - 1];
  }
  return nullptr;
}

Pickle::Pickle(const std::string& file,
               const std::vector<char>& bytes,
               const ReadStorage& read_storage) {
  root_ = PickleMachine(file, {bytes.data(), bytes.size()}, read_storage, values_).Run();
}

}  // namespace cosplat
