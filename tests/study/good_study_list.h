// A list of runs with every kind of entry, for tests that change it.
#pragma once

namespace cosplat::test {

inline constexpr const char* kGoodStudyList = R"({
  "defaults": {"arguments": ["--eval"], "seeds": [0, 5], "checkpoints": [10]},
  "data": [
    {"name": "fox", "kind": "scene", "source": "a fox", "counts": [200, 100],
     "published": {"Others'": {"PSNR": 31.5, "gaussians": 90000}}},
    {"name": "head", "kind": "avatar", "make_head": ["--size", "64"], "seeds": [3],
     "checkpoints": []}],
  "runs": [
    {"name": "dcsh", "label": "DCSH", "groups": ["bases", "pruning"], "minus": ["sh"]},
    {"name": "sh", "arguments": ["--basis", "sh"]},
    {"name": "speedy", "arguments": ["--prune-to", "{count}"], "data": ["fox"], "seeds": [0]},
    {"name": "lp", "arguments": ["--prune-lambda", "{value}"], "values": [5e-4, 2],
     "data": ["head"]}]})";

}  // namespace cosplat::test
