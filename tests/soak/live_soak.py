#!/usr/bin/env python3
"""A live avatar for hours, by the C interface, with a tracker that fails.

    COSPLAT_LIBRARY=build/cpu/avatar/plugin/libcosplat.so PYTHONPATH=apps/python \
      tests/soak/live_soak.py avatar.glb model.npz --minutes 480

The tracker, a process of its own, sends JSON frames by UDP, 30 a second. A tenth of them are not
sent, a twentieth are garbage, and it is killed and started again, with numbers that begin anew,
some times a minute. The host draws 512 x 512 (--side) at 30 frames a second. --fps 150 has the
packets and frames of eight hours, and as many restarts per frame, in 96 minutes. Prints a row per
minute (milliseconds from when a frame was due to when it was drawn, resident memory, what the
library counted), and at the end what must hold:

- memory: none gained after the first minute but 2 MB;
- every packet that was sent is counted as a frame or as a loss of one kind;
- frames that were drawn more than 33 ms after they were due. Other processes make some: ends with
  1 for the other two.
"""
import argparse
import json
import math
import os
import random
import signal
import socket
import subprocess
import sys
import time

LATE_MS = 33
DROPPED, GARBAGE = 0.10, 0.05
MEMORY_MB = 2


def garbage(packet, chance):
    """Of the five kinds of `cosplat send --bad`."""
    kind = chance.randrange(5)
    if kind == 0:
        return packet[: len(packet) // 2]
    if kind == 1:
        return packet[:-1] + b', "jaw": [NaN, 0, 0]}'
    if kind == 2:
        return packet[:-1] + b', "neck": [0, 0]}'
    if kind == 3:
        return packet + b" " * 20000
    return bytes(chance.randrange(32, 232) for _ in range(64))


def track(port, seed, fps):
    """The tracker: until SIGTERM, then prints how many packets it has sent and how many not."""
    stop = []
    signal.signal(signal.SIGTERM, lambda *_: stop.append(True))
    chance = random.Random(seed)
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    counts = {"good": 0, "garbage": 0, "dropped": 0}
    start = time.monotonic()
    number = 0
    while not stop:
        t = number / fps
        time.sleep(max(0.0, start + t - time.monotonic()))
        packet = json.dumps(
            {
                "seq": number,
                "time": t,
                "expression": [math.sin(t), math.cos(2 * t)],
                "jaw": [0.1 + 0.1 * math.sin(7 * t), 0, 0],
            }
        ).encode()
        number += 1
        draw = chance.random()
        if draw < DROPPED:
            counts["dropped"] += 1
            continue
        bad = draw < DROPPED + GARBAGE
        counts["garbage" if bad else "good"] += 1
        out.sendto(garbage(packet, chance) if bad else packet, ("127.0.0.1", port))
    print(json.dumps(counts))


class Tracker:
    """Runs `track` for some seconds, and again after a pause."""

    def __init__(self, port, fps):
        self.port, self.fps = port, fps
        self.process, self.change, self.starts = None, 0.0, 0
        self.sent = {"good": 0, "garbage": 0, "dropped": 0}
        self.chance = random.Random(1)

    def step(self, now):
        if now < self.change:
            return
        if self.process:
            self.stop()
            self.change = now + self.chance.uniform(0.2, 4)
        else:
            self.starts += 1
            numbers = [str(n) for n in (self.port, self.starts, self.fps)]
            command = [sys.executable, __file__, "--track"] + numbers
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE)
            self.change = now + self.chance.uniform(5, 40) * 30 / self.fps

    def stop(self):
        if not self.process:
            return
        self.process.terminate()
        for kind, count in json.loads(self.process.communicate()[0]).items():
            self.sent[kind] += count
        self.process = None


def memory_mb():
    with open("/proc/self/status") as lines:
        return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def run(options):
    import cosplat

    port = free_port()
    avatar = cosplat.Avatar(options.avatar, flame=options.model)
    avatar.set_drive("udp://127.0.0.1:%d" % port)
    avatar.advance(time.monotonic_ns())  # listens
    fps = options.fps
    tracker = Tracker(port, fps)
    side = options.side
    pixels = bytearray(4 * side * side)
    minute, late, worst, first_mb, total = [], 0, (0.0, 0.0), None, 0
    print("minute  median    99 %     max ms  late  memory MB   shown  lost  restarts", flush=True)
    start = time.monotonic()
    frames = int(options.minutes * 60 * fps)
    for number in range(frames):
        due = start + number / fps
        time.sleep(max(0.0, due - time.monotonic()))
        tracker.step(time.monotonic())
        worked = time.process_time()
        avatar.advance(time.monotonic_ns())
        avatar.render(side, side, pixels)
        took = (time.monotonic() - due) * 1e3
        minute.append(took)
        late += took > LATE_MS
        worst = max(worst, (took, (time.process_time() - worked) * 1e3))
        if took > 5 * LATE_MS:  # the machine stood still: begin again from here
            start += took / 1e3
        if len(minute) == 60 * fps or number == frames - 1:
            total += len(minute)
            minute.sort()
            h = avatar.health()
            lost = h.drive_malformed + h.drive_oversize + h.drive_reordered + h.drive_flooded
            mb = memory_mb()
            first_mb = first_mb or mb
            print(
                "%6d %7.2f %7.2f %9.2f %5d %10.2f %7d %5d %9d"
                % (
                    round(total / fps / 60),
                    minute[len(minute) // 2],
                    minute[len(minute) * 99 // 100],
                    minute[-1],
                    sum(t > LATE_MS for t in minute),
                    mb,
                    h.accepted,
                    lost,
                    tracker.starts - 1,
                ),
                flush=True,
            )
            minute = []
    tracker.stop()
    time.sleep(0.2)
    avatar.advance(time.monotonic_ns())
    h = avatar.health()
    sent = tracker.sent["good"] + tracker.sent["garbage"]
    counted = {
        "frames": h.drive_frames,
        "replaced": h.drive_replaced,
        "reordered": h.drive_reordered,
        "malformed": h.drive_malformed,
        "oversize": h.drive_oversize,
        "flooded": h.drive_flooded,
        "late": h.late,
    }
    grown = memory_mb() - first_mb
    print("sent: %s, %d restarts" % (tracker.sent, tracker.starts - 1))
    print("counted: %s; held %d, decayed %d, returned %d" % (counted, h.held, h.decayed, h.returned))
    arrived = sum(counted.values()) - h.late  # those are frames of the drive, too
    print("packets sent %d, counted %d" % (sent, arrived))
    print("memory since the first minute: %+.2f MB" % grown)
    print(
        "frames drawn %d, late by more than %d ms %d, the latest %.1f ms, %.1f ms of the processor"
        % ((frames, LATE_MS, late) + worst)
    )
    return 0 if arrived == sent and grown <= MEMORY_MB else 1


def main():
    if sys.argv[1:2] == ["--track"]:
        track(*(int(number) for number in sys.argv[2:5]))
        return 0
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("avatar")
    parser.add_argument("model", help="FLAME's, or the made head's model.npz")
    parser.add_argument("--minutes", type=float, default=480)
    parser.add_argument("--fps", type=int, default=30, help="frames and packets a second")
    parser.add_argument("--side", type=int, default=512, help="of the image, in pixels")
    return run(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
