#!/usr/bin/env python3
"""Writes a picture of an avatar as a PNG file, with nothing but Python's own library.

    python3 render_png.py avatar.glb flame2023.pkl picture.png --jaw 0.2 --azimuth 30
"""

import argparse
import math
import struct
import sys
import zlib

import cosplat


def png(width, height, rgba):
    def chunk(kind, data):
        check = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)

    row = 4 * width
    rows = b"".join(b"\0" + rgba[y * row : (y + 1) * row] for y in range(height))  # 0: no filter
    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)  # 8 bits of each of RGBA
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


def main():
    parser = argparse.ArgumentParser(description="Writes a picture of an avatar as a PNG file.")
    parser.add_argument("avatar", help="a .glb")
    parser.add_argument("flame", help="the FLAME model that it was trained with")
    parser.add_argument("out", help="a .png")
    parser.add_argument("--size", type=int, default=512, help="pixels either way")
    parser.add_argument("--jaw", type=float, default=0.0, help="how far the mouth is open: radians")
    parser.add_argument("--azimuth", type=float, default=0.0, help="of the camera: degrees")
    parser.add_argument("--drive", help="a recording, whose face is shown")
    parser.add_argument("--at", type=float, default=0.0, help="seconds into the recording")
    options = parser.parse_args()

    with cosplat.Avatar(options.avatar, flame=options.flame) as avatar:
        size = options.size
        avatar.set_camera(avatar.orbit_camera(size, size, azimuth=math.radians(options.azimuth)))
        if options.drive:
            avatar.set_drive(options.drive)
            frames = round(25 * options.at)
            for frame in range(frames + 1):  # the face comes to the recording from rest
                avatar.advance(frame * 1_000_000_000 // 25)
        else:
            avatar.set_parameters(jaw=(options.jaw, 0, 0))
        rgba = avatar.render(size, size)
    with open(options.out, "wb") as file:
        file.write(png(size, size, rgba))


if __name__ == "__main__":
    try:
        main()
    except (cosplat.Error, OSError) as error:
        sys.exit(f"render_png.py: {error}")
