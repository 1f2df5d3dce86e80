"""Pictures of libcosplat.so for test/run.mjs: python3 reference.py CLIP AVATAR FLAME OUT SIZE FRAMES.

CLIP is the folder of cosplat.py. Writes OUT/frames.json (what was set) and OUT/pictures.rgba, and
prints the milliseconds per picture, median and least, the first ones left out.
"""

import json
import math
import sys
import time
from pathlib import Path

sys.path.insert(0, sys.argv[1])
import cosplat  # noqa: E402

avatar_path, flame_path, out, size, count = sys.argv[2:4] + [Path(sys.argv[4])] + [int(x) for x in sys.argv[5:7]]
frames = []
for i in range(count):
    t = i / 10
    frames.append(
        {
            "parameters": {
                "expression": [math.sin((k + 1) * t) for k in range(8)],
                "root": [0, 0.2 * math.sin(t), 0],
                "neck": [0.1 * math.sin(2 * t), 0, 0],
                "jaw": [0.15 - 0.15 * math.cos(3 * t), 0, 0],
                "time": 40 * i,
            },
            "orbit": {"azimuth": 0.5 * math.sin(t), "elevation": 0.2 * math.cos(t), "zoom": 1},
        }
    )
names = {"leftEye": "left_eye", "rightEye": "right_eye"}
times = []
with cosplat.Avatar(avatar_path, flame=flame_path) as avatar, open(out / "pictures.rgba", "wb") as pictures:
    for i, frame in enumerate(frames):
        joints = {names.get(k, k): v for k, v in frame["parameters"].items() if k != "time"}
        begin = time.perf_counter()
        avatar.set_parameters(time_ns=40_000_000 * i, **joints)
        avatar.set_camera(avatar.orbit_camera(size, size, **frame["orbit"]))
        pixels = avatar.render(size, size)
        times.append(1e3 * (time.perf_counter() - begin))
        pictures.write(pixels)
(out / "frames.json").write_text(json.dumps(frames))
times = sorted(times[5:] or times)
print(times[len(times) // 2], times[0])
