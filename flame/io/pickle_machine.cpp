// The opcodes that create plain values, fill containers and rearrange the stack.
#include "flame/io/pickle_machine.h"

#include "splat/base/text.h"

namespace cosplat {

using Kind = PickleValue::Kind;

bool PickleMachine::Constant(uint8_t opcode) {
  switch (opcode) {
    case 'N':
      return Push(New(Kind::kNone));
    case 0x88:
      return PushInteger(Kind::kBool, 1);
    case 0x89:
      return PushInteger(Kind::kBool, 0);
    case 'J':
      return PushInteger(Kind::kInteger, in_.Signed(4));
    case 'K':
      return PushInteger(Kind::kInteger, int64_t(in_.Unsigned(1)));
    case 'M':
      return PushInteger(Kind::kInteger, int64_t(in_.Unsigned(2)));
    case 'I': {
      const std::string_view line = in_.Line();
      const bool is_bool = line == "00" || line == "01";
      return PushInteger(is_bool ? Kind::kBool : Kind::kInteger, in_.ParseInteger(line));
    }
    case 'L': {
      std::string_view line = in_.Line();
      if (line.ends_with('L')) line.remove_suffix(1);
      return PushInteger(Kind::kInteger, in_.ParseInteger(line));
    }
    case 0x8a:
    case 0x8b: {
      const uint64_t count = in_.Unsigned(opcode == 0x8a ? 1 : 4);
      if (count > 8) in_.Fail("an integer of " + std::to_string(count) + " bytes");
      return PushInteger(Kind::kInteger, in_.Signed(int(count)));
    }
    case 'F':
      return PushFloat(in_.ParseFloat(in_.Line()));
    case 'G':
      return PushFloat(in_.BigEndianDouble());
    default:
      return false;
  }
}

bool PickleMachine::Text(uint8_t opcode) {
  switch (opcode) {
    case 'S':
      return PushText(Kind::kText, in_.ParseQuoted(in_.Line()));
    case 'V':
      return PushText(Kind::kText, in_.ParseRawUnicode(in_.Line()));
    case 'U':
    case 0x8c:
      return PushText(Kind::kText, in_.Bytes(in_.Unsigned(1)));
    case 'T':
    case 'X':
      return PushText(Kind::kText, in_.Bytes(in_.Unsigned(4)));
    case 0x8d:
      return PushText(Kind::kText, in_.Bytes(in_.Unsigned(8)));
    case 'C':
      return PushText(Kind::kBytes, in_.Bytes(in_.Unsigned(1)));
    case 'B':
      return PushText(Kind::kBytes, in_.Bytes(in_.Unsigned(4)));
    case 0x8e:
      return PushText(Kind::kBytes, in_.Bytes(in_.Unsigned(8)));
    default:
      return false;
  }
}

// Appends to the list or dictionary on top of the stack.
bool PickleMachine::Extend(Kind kind, const std::vector<const PickleValue*>& items) {
  PickleValue* target = Top();
  if (target->kind != kind)
    in_.Fail(kind == Kind::kList ? "appends to a value that is not a list"
                                 : "sets items of a value that is not a dictionary");
  if (kind == Kind::kDict && items.size() % 2 != 0) in_.Fail("a dictionary key has no value");
  target->items.insert(target->items.end(), items.begin(), items.end());
  return true;
}

bool PickleMachine::Container(uint8_t opcode) {
  switch (opcode) {
    case ']':
      return Push(New(Kind::kList));
    case '}':
      return Push(New(Kind::kDict));
    case ')':
      return PushTuple(0);
    case 0x85:
      return PushTuple(1);
    case 0x86:
      return PushTuple(2);
    case 0x87:
      return PushTuple(3);
    case 't':
      return PushTuple(PopToMark());
    case 'l':
    case 'd': {
      const Kind kind = opcode == 'l' ? Kind::kList : Kind::kDict;
      const auto items = PopToMark();
      Push(New(kind));
      return Extend(kind, items);
    }
    case 'a': {
      const PickleValue* item = Pop();
      return Extend(Kind::kList, {item});
    }
    case 's': {
      const PickleValue* value = Pop();
      const PickleValue* key = Pop();
      return Extend(Kind::kDict, {key, value});
    }
    case 'e':
      return Extend(Kind::kList, PopToMark());
    case 'u':
      return Extend(Kind::kDict, PopToMark());
    default:
      return false;
  }
}

bool PickleMachine::Stack(uint8_t opcode) {
  switch (opcode) {
    case 0x80: {
      const uint64_t protocol = in_.Unsigned(1);
      if (protocol > 4) in_.Fail(Format("pickle protocol {}, expected 0 to 4", protocol));
      return true;
    }
    case 0x95:
      in_.Unsigned(8);
      return true;  // FRAME: a hint for buffering
    case '(':
      marks_.push_back(stack_.size());
      return true;
    case '1':
      PopToMark();
      return true;
    case '0':
      // As in Python, POP right after MARK removes the mark.
      if (!marks_.empty() && marks_.back() == stack_.size())
        marks_.pop_back();
      else
        Pop();
      return true;
    case '2':
      return Push(Top());
    case 'p':
      return Memoize(MemoIndexOfLine());
    case 'q':
      return Memoize(in_.Unsigned(1));
    case 'r':
      return Memoize(in_.Unsigned(4));
    case 0x94:
      return Memoize(memo_.size());
    case 'g':
      return PushMemo(MemoIndexOfLine());
    case 'h':
      return PushMemo(in_.Unsigned(1));
    case 'j':
      return PushMemo(in_.Unsigned(4));
    default:
      return false;
  }
}

}  // namespace cosplat
