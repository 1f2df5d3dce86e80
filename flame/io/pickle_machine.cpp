// The opcodes that create plain values, fill containers and rearrange the stack.
#include "flame/io/pickle_machine.h"

#include "splat/base/text.h"

namespace cosplat {

using Kind = PickleValue::Kind;

bool PickleMachine::Constant(uint8_t opcode) {
  switch (opcode) {
    case 'N':
      Push(New(Kind::kNone));
      return true;
    case 0x88:
      PushInteger(Kind::kBool, 1);
      return true;
    case 0x89:
      PushInteger(Kind::kBool, 0);
      return true;
    case 'J':
      PushInteger(Kind::kInteger, in_.Signed(4));
      return true;
    case 'K':
      PushInteger(Kind::kInteger, int64_t(in_.Unsigned(1)));
      return true;
    case 'M':
      PushInteger(Kind::kInteger, int64_t(in_.Unsigned(2)));
      return true;
    case 'I': {
      const std::string_view line = in_.Line();
      const bool is_bool = line == "00" || line == "01";
      PushInteger(is_bool ? Kind::kBool : Kind::kInteger, in_.ParseInteger(line));
      return true;
    }
    case 'L': {
      std::string_view line = in_.Line();
      if (line.ends_with('L')) line.remove_suffix(1);
      PushInteger(Kind::kInteger, in_.ParseInteger(line));
      return true;
    }
    case 0x8a:
    case 0x8b: {
      const uint64_t count = in_.Unsigned(opcode == 0x8a ? 1 : 4);
      if (count > 8) in_.Fail("an integer of " + std::to_string(count) + " bytes");
      PushInteger(Kind::kInteger, in_.Signed(int(count)));
      return true;
    }
    case 'F':
      PushFloat(in_.ParseFloat(in_.Line()));
      return true;
    case 'G':
      PushFloat(in_.BigEndianDouble());
      return true;
    default:
      return false;
  }
}

bool PickleMachine::Text(uint8_t opcode) {
  switch (opcode) {
    case 'S':
      PushText(Kind::kText, in_.ParseQuoted(in_.Line()));
      return true;
    case 'V':
      PushText(Kind::kText, in_.ParseRawUnicode(in_.Line()));
      return true;
    case 'U':
    case 0x8c:
      PushText(Kind::kText, in_.Bytes(in_.Unsigned(1)));
      return true;
    case 'T':
    case 'X':
      PushText(Kind::kText, in_.Bytes(in_.Unsigned(4)));
      return true;
    case 0x8d:
      PushText(Kind::kText, in_.Bytes(in_.Unsigned(8)));
      return true;
    case 'C':
      PushText(Kind::kBytes, in_.Bytes(in_.Unsigned(1)));
      return true;
    case 'B':
      PushText(Kind::kBytes, in_.Bytes(in_.Unsigned(4)));
      return true;
    case 0x8e:
      PushText(Kind::kBytes, in_.Bytes(in_.Unsigned(8)));
      return true;
    default:
      return false;
  }
}

// Appends to the list or dictionary on top of the stack.
void PickleMachine::Extend(Kind kind, const std::vector<const PickleValue*>& items) {
  PickleValue* target = Top();
  if (target->kind != kind)
    in_.Fail(kind == Kind::kList ? "appends to a value that is not a list"
                                 : "sets items of a value that is not a dictionary");
  if (kind == Kind::kDict && items.size() % 2 != 0) in_.Fail("a dictionary key has no value");
  target->items.insert(target->items.end(), items.begin(), items.end());
}

bool PickleMachine::Container(uint8_t opcode) {
  switch (opcode) {
    case ']':
      Push(New(Kind::kList));
      return true;
    case '}':
      Push(New(Kind::kDict));
      return true;
    case ')':
      PushTuple(0);
      return true;
    case 0x85:
      PushTuple(1);
      return true;
    case 0x86:
      PushTuple(2);
      return true;
    case 0x87:
      PushTuple(3);
      return true;
    case 't':
      PushTuple(PopToMark());
      return true;
    case 'l':
    case 'd': {
      const Kind kind = opcode == 'l' ? Kind::kList : Kind::kDict;
      const auto items = PopToMark();
      Push(New(kind));
      Extend(kind, items);
      return true;
    }
    case 'a': {
      const PickleValue* item = Pop();
      Extend(Kind::kList, {item});
      return true;
    }
    case 's': {
      const PickleValue* value = Pop();
      const PickleValue* key = Pop();
      Extend(Kind::kDict, {key, value});
      return true;
    }
    case 'e':
      Extend(Kind::kList, PopToMark());
      return true;
    case 'u':
      Extend(Kind::kDict, PopToMark());
      return true;
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
      Push(Top());
      return true;
    case 'p':
      Memoize(MemoIndexOfLine());
      return true;
    case 'q':
      Memoize(in_.Unsigned(1));
      return true;
    case 'r':
      Memoize(in_.Unsigned(4));
      return true;
    case 0x94:
      Memoize(memo_.size());
      return true;
    case 'g':
      PushMemo(MemoIndexOfLine());
      return true;
    case 'h':
      PushMemo(in_.Unsigned(1));
      return true;
    case 'j':
      PushMemo(in_.Unsigned(4));
      return true;
    default:
      return false;
  }
}

}  // namespace cosplat
