#!/usr/bin/python3
"""Rewrites PNG files with a palette of at most 256 colours: smaller_png.py FILE.png... (Python with numpy)

The colours are means of the most frequent ones; nothing is dithered. A file that would not become smaller stays.
"""
import struct
import sys
import zlib

import numpy as np


def pixels(data):
    """h x w x 3 of a PNG with 8 bits, RGB or RGBA (alpha is dropped)."""
    at, idat, head = 8, b"", None
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", data[at + 8:at + 21])
        if kind == b"IDAT":
            idat += data[at + 8:at + 8 + size]
        at += 12 + size
    width, height, depth, colour, _, _, interlaced = head
    if depth != 8 or colour not in (2, 6) or interlaced:
        return None
    step = 3 if colour == 2 else 4
    raw = np.frombuffer(zlib.decompress(idat), np.uint8).reshape(height, 1 + step * width)
    rows = np.zeros((height + 1, step * width), np.uint8)
    for y in range(height):
        rows[y + 1] = unfiltered(raw[y, 0], raw[y, 1:], rows[y], step)
    return rows[1:].reshape(height, width, step)[:, :, :3]


def unfiltered(kind, line, above, step):
    if kind == 0:
        return line
    if kind == 2:
        return line + above
    if kind == 1:
        return np.cumsum(line.reshape(-1, step), axis=0, dtype=np.uint8).reshape(-1)
    out = np.zeros(len(line) + step, np.int64)
    up = np.concatenate([np.zeros(step, np.int64), above.astype(np.int64)])
    for i, value in enumerate(line.tolist()):
        a, b, c = out[i], up[i + step], up[i]
        if kind == 3:
            guess = (a + b) // 2
        else:
            p, q, r = abs(b - c), abs(a - c), abs(a + b - 2 * c)
            guess = a if p <= q and p <= r else b if q <= r else c
        out[i + step] = (value + guess) & 255
    return out[step:].astype(np.uint8)


def palette_of(image, most=256):
    """Palette and the index of each pixel."""
    flat = image.reshape(-1, 3)
    colours, index, counts = np.unique(flat, axis=0, return_inverse=True, return_counts=True)
    if len(colours) <= most:
        return colours, index
    # Boxes are split where they hold the most, across their longest side, at the median.
    boxes, wanted = [np.arange(len(colours))], colours.astype(float)
    while len(boxes) < most:
        spread = [np.ptp(wanted[b], axis=0).max() * counts[b].sum() ** 0.4 if len(b) > 1 else -1 for b in boxes]
        box = boxes.pop(int(np.argmax(spread)))
        order = box[np.argsort(wanted[box][:, np.argmax(np.ptp(wanted[box], axis=0))], kind="stable")]
        middle = int(np.clip(np.searchsorted(np.cumsum(counts[order]), counts[order].sum() / 2), 1, len(order) - 1))
        boxes += [order[:middle], order[middle:]]
    palette, of = np.zeros((len(boxes), 3), np.uint8), np.zeros(len(colours), np.int64)
    for k, box in enumerate(boxes):
        palette[k] = np.round(np.average(wanted[box], axis=0, weights=counts[box]))
        of[box] = k
    return palette, of[index]


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


for name in sys.argv[1:]:
    with open(name, "rb") as file:
        before = file.read()
    image = pixels(before)
    if image is None:
        continue
    palette, index = palette_of(image)
    height, width = image.shape[:2]
    rows = np.zeros((height, width + 1), np.uint8)
    rows[:, 1:] = np.asarray(index, np.uint8).reshape(height, width)
    after = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
             + chunk(b"PLTE", palette.astype(np.uint8).tobytes()) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9))
             + chunk(b"IEND", b""))
    if len(after) < len(before):
        with open(name, "wb") as file:
            file.write(after)
    print(f"{name}: {len(before) // 1024} kB, now {min(len(after), len(before)) // 1024} kB")
