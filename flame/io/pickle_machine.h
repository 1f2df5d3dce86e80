// The pickle machine: a stack, marks on it, and a memo. Private to flame/io/pickle.cpp.
#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "flame/io/pickle.h"
#include "flame/io/pickle_input.h"

namespace cosplat {

// FLAME's files contain some hundred values; one value per array element would be another kind of
// file. Together with the bound on text, this keeps a small malicious file from filling memory.
constexpr size_t kMaxPickleValues = 1'000'000;

class PickleMachine {
 public:
  PickleMachine(const std::string& file,
                std::string_view bytes,
                const Pickle::ReadStorage& read_storage,
                std::deque<PickleValue>& values)
      : in_(file, bytes),
        read_storage_(read_storage),
        values_(values),
        text_left_(4 * bytes.size() + 1024) {}

  // Runs to STOP and returns the value on top of the stack.
  const PickleValue* Run();

 private:
  // Each handles a group of opcodes and returns whether the opcode belongs to it (Object and the
  // loop are in pickle.cpp).
  bool Constant(uint8_t opcode);
  bool Text(uint8_t opcode);
  bool Container(uint8_t opcode);
  bool Stack(uint8_t opcode);
  bool Object(uint8_t opcode);

  PickleValue* New(PickleValue::Kind kind) {
    if (values_.size() >= kMaxPickleValues)
      in_.Fail("more than " + std::to_string(kMaxPickleValues) + " values");
    values_.emplace_back().kind = kind;
    return &values_.back();
  }
  // What handles an opcode returns true, as what calls it does.
  bool Push(PickleValue* value) {
    stack_.push_back(value);
    return true;
  }
  bool PushInteger(PickleValue::Kind kind, int64_t value) {
    PickleValue* v = New(kind);
    v->integer = value;
    return Push(v);
  }
  bool PushFloat(double value) {
    PickleValue* v = New(PickleValue::Kind::kFloat);
    v->real = value;
    return Push(v);
  }
  bool PushText(PickleValue::Kind kind, std::string_view text) {
    if (text.size() > text_left_) in_.Fail("strings exceed the size of the file");
    text_left_ -= text.size();
    PickleValue* v = New(kind);
    v->text = text;
    return Push(v);
  }

  // Values below the last mark are inaccessible until it is removed.
  size_t Floor() const { return marks_.empty() ? 0 : marks_.back(); }
  PickleValue* Top() {
    if (stack_.size() <= Floor()) in_.Fail("the stack is empty");
    return stack_.back();
  }
  PickleValue* Pop() {
    PickleValue* top = Top();
    stack_.pop_back();
    return top;
  }
  std::vector<const PickleValue*> PopToMark() {
    if (marks_.empty()) in_.Fail("there is no mark on the stack");
    const size_t begin = marks_.back();
    marks_.pop_back();
    std::vector<const PickleValue*> items(stack_.begin() + begin, stack_.end());
    stack_.resize(begin);
    return items;
  }
  bool PushTuple(std::vector<const PickleValue*> items) {
    PickleValue* tuple = New(PickleValue::Kind::kTuple);
    tuple->items = std::move(items);
    return Push(tuple);
  }
  bool PushTuple(size_t count) {
    std::vector<const PickleValue*> items(count);
    for (size_t i = count; i-- > 0;) items[i] = Pop();
    return PushTuple(std::move(items));
  }
  bool Extend(PickleValue::Kind kind, const std::vector<const PickleValue*>& items);
  bool Memoize(uint64_t index) {
    if (memo_.size() >= kMaxPickleValues) in_.Fail("the memo is too large");
    memo_[index] = Top();
    return true;
  }
  bool PushMemo(uint64_t index) {
    const auto found = memo_.find(index);
    if (found == memo_.end()) in_.Fail("memo " + std::to_string(index) + " was never set");
    return Push(found->second);
  }
  uint64_t MemoIndexOfLine() {
    const int64_t index = in_.ParseInteger(in_.Line());
    if (index < 0) in_.Fail("memo index " + std::to_string(index) + " is negative");
    return uint64_t(index);
  }

  bool PushClass(std::string_view module, std::string_view name);
  bool Call();
  bool Construct(const PickleValue* type, const PickleValue* arguments);
  bool PushStorage(const PickleValue* identifier);

  PickleInput in_;
  const Pickle::ReadStorage& read_storage_;
  std::deque<PickleValue>& values_;
  size_t text_left_;
  std::vector<PickleValue*> stack_;
  std::vector<size_t> marks_;
  std::unordered_map<uint64_t, PickleValue*> memo_;
  std::unordered_map<std::string, PickleValue*> storages_;
};

}  // namespace cosplat
