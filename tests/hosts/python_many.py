"""Opens and closes an avatar a thousand times, then draws from several threads at once: no memory is
kept, and every picture is the first one. Arguments: avatar, FLAME model."""
import sys
import threading

import cosplat

OPENED, THREADS, PICTURES, SIDE = 1000, 4, 25, 48
KEPT_KB = 2048


def memory_kb():
    with open("/proc/self/status") as lines:
        return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def picture():
    with cosplat.Avatar(sys.argv[1], flame=sys.argv[2]) as avatar:
        avatar.set_parameters(expression=[0.5], jaw=(0.1, 0, 0))
        return bytes(avatar.render(SIDE, SIDE))


first = picture()
# The allocator keeps some megabytes, and sometimes gives them back: the most of each half counts.
most = [0, 0]
for number in range(OPENED):
    cosplat.Avatar(sys.argv[1], flame=sys.argv[2]).close()
    half = number * 2 // OPENED
    most[half] = max(most[half], memory_kb())
grown = most[1] - most[0]
if grown > KEPT_KB:
    sys.exit("%d opened and closed kept %d kB" % (OPENED // 2, grown))

different = []


def draw():
    different.extend(1 for _ in range(PICTURES) if picture() != first)


threads = [threading.Thread(target=draw) for _ in range(THREADS)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
if different:
    sys.exit("%d of %d pictures differ" % (len(different), THREADS * PICTURES))
print("%d opened and closed: %+d kB; %d pictures by %d threads are the same"
      % (OPENED, grown, THREADS * PICTURES, THREADS))
