#!/usr/bin/env python3
"""Draws the pictures of docs/layouts.md: skip.svg, pair.svg and compressed8.svg, beside this file."""
import math
import os

BOX, LEAF, LINK, OTHER, INK = "#dbe7f5", "#f6e3c5", "#f3c9c9", "#dcebd6", "#333333"
BYTE = 16  # width of a byte in the tables


class Picture:
    def __init__(self, width, height):
        self.width, self.height, self.parts = width, height, []

    def rect(self, x, y, width, height, fill="none", stroke=INK, dash=""):
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" fill="{fill}" '
                          f'stroke="{stroke}"{dashes}/>')

    def text(self, x, y, words, size=13, anchor="middle", fill=INK):
        self.parts.append(f'<text x="{x:g}" y="{y:g}" font-size="{size}" text-anchor="{anchor}" fill="{fill}">{words}</text>')

    def line(self, x0, y0, x1, y1):
        self.parts.append(f'<line x1="{x0:g}" y1="{y0:g}" x2="{x1:g}" y2="{y1:g}" stroke="{INK}"/>')

    def arrow(self, path, color=INK):
        self.parts.append(f'<path d="{path}" fill="none" stroke="{color}" stroke-width="1.5" '
                          f'marker-end="url(#{color[1:]})"/>')

    def table(self, x, y, rows):
        """Rows of 16 bytes: (words, bytes, color)."""
        for row, fields in enumerate(rows):
            left = x
            self.text(x - 8, y + 40 * row + 20, f"{16 * row}", 11, "end", "#777777")
            for words, count, color in fields:
                self.rect(left, y + 40 * row, BYTE * count, 30, color)
                self.text(left + BYTE * count / 2, y + 40 * row + 20, words, 12)
                left += BYTE * count

    def save(self, name):
        colors = {INK, "#1f6fb2", "#c04040"}
        markers = "".join(f'<marker id="{color[1:]}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
                          f'orient="auto"><path d="M0 0L8 4L0 8z" fill="{color}"/></marker>' for color in sorted(colors))
        head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}" '
                f'viewBox="0 0 {self.width} {self.height}" font-family="Helvetica, Arial, sans-serif">')
        body = "\n".join(self.parts)
        path = os.path.join(os.path.dirname(os.path.abspath(__file__)), name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'{head}\n<defs>{markers}</defs>\n<rect width="100%" height="100%" fill="white"/>\n{body}\n</svg>\n')


def tree(picture, x, y):
    """Nodes 0 to 4 in depth-first order: 0 above 1 and 4, 1 above 2 and 3."""
    places = {0: (x + 90, y), 1: (x + 50, y + 55), 4: (x + 130, y + 55), 2: (x + 20, y + 110), 3: (x + 80, y + 110)}
    for parent, child in ((0, 1), (0, 4), (1, 2), (1, 3)):
        picture.line(*places[parent], *places[child])
    for node, (px, py) in places.items():
        picture.rect(px - 15, py - 13, 30, 26, LEAF if node in (2, 3, 4) else BOX)
        picture.text(px, py + 5, f"{node}")


def cells(picture, x, y, names, width=76):
    for node, name in enumerate(names):
        picture.rect(x + width * node, y, width, 34, LEAF if name == "leaf" else BOX)
        picture.text(x + width * node + width / 2, y + 22, f"{node}: {name}", 12)
    return [x + width * node + width / 2 for node in range(len(names) + 1)]


def arc(x0, x1, y, height):
    return f"M{x0:g} {y:g}C{x0:g} {y + height:g} {x1:g} {y + height:g} {x1:g} {y + math.copysign(2, height):g}"


def skip():
    picture = Picture(670, 280)
    tree(picture, 10, 40)
    middles = cells(picture, 215, 75, ["inner", "inner", "leaf", "leaf", "leaf"])
    for left, right in zip(middles, middles[1:]):
        picture.arrow(arc(left + 6, right - 6, 74, -26), "#1f6fb2")
    picture.text(405, 36, "met, or a leaf: the next node", 12, fill="#1f6fb2")
    picture.text(middles[5] + 2, 97, "end", 12)
    picture.arrow(arc(middles[1], middles[4] - 8, 110, 42), "#c04040")
    picture.arrow(arc(middles[0], middles[5], 110, 74), "#c04040")
    picture.text(405, 184, "missed: where the link leads", 12, fill="#c04040")
    picture.table(60, 205, [[("lower x", 4, BOX), ("lower y", 4, BOX), ("lower z", 4, BOX), ("link", 4, LINK)],
                            [("upper x", 4, BOX), ("upper y", 4, BOX), ("upper z", 4, BOX), ("count", 4, LINK)]])
    picture.text(330, 225, "inner: number of the node behind all below", 12, "start")
    picture.text(330, 241, "leaf: its first place in primitive_ids", 12, "start")
    picture.text(330, 265, "primitives of a leaf; 0: inner", 12, "start")
    picture.save("skip.svg")


def pair():
    picture = Picture(640, 385)
    tree(picture, 10, 40)
    middles = cells(picture, 215, 75, ["inner", "inner", "leaf", "leaf", "leaf"])
    picture.arrow(arc(middles[0], middles[1] - 8, 74, -26), "#1f6fb2")
    picture.arrow(arc(middles[1] + 8, middles[2], 74, -26), "#1f6fb2")
    picture.text(330, 36, "left", 12, fill="#1f6fb2")
    picture.arrow(arc(middles[1], middles[3], 110, 40), "#c04040")
    picture.arrow(arc(middles[0], middles[4], 110, 66), "#c04040")
    picture.text(405, 178, "right", 12, fill="#c04040")
    corner = lambda side, color: [(f"{side} x", 4, color), (f"{side} y", 4, color), (f"{side} z", 4, color)]
    picture.table(60, 195, [corner("lower", BOX) + [("left", 4, LINK)], corner("upper", BOX) + [("right", 4, LINK)],
                            corner("lower", OTHER) + [("count", 4, LINK)], corner("upper", OTHER) + [("first", 4, LINK)]])
    for row, words in ((0.5, "box of the left child"), (2.5, "box of the right child")):
        picture.text(330, 215 + 40 * row, words, 12, "start")
    picture.text(60, 370, "a leaf: boxes of zeros, count of its primitives, first of its places in primitive_ids", 12, "start")
    picture.save("pair.svg")


def compressed8():
    picture = Picture(720, 360)
    x, y, step = 20, 60, 17.5
    for i in range(17):
        picture.parts.append(f'<path d="M{x + i * step:g} {y}v{16 * step:g}M{x} {y + i * step:g}h{16 * step:g}" '
                             'stroke="#dddddd"/>')
    picture.rect(x, y, 16 * step, 16 * step)
    # In steps of the grid from the lower left corner: exact boxes, with what child it is.
    for (left, low, right, high), name in (((0, 0, 5.4, 4.2), "slot 0"), ((1.3, 8.6, 6.7, 14.3), "slot 2"),
                                           ((8.2, 0.7, 15.6, 6.4), "slot 4"), ((9.4, 9.3, 16, 16), "slot 6")):
        outer = [math.floor(left), math.floor(low), math.ceil(right), math.ceil(high)]
        picture.rect(x + outer[0] * step, y + (16 - outer[3]) * step, (outer[2] - outer[0]) * step,
                     (outer[3] - outer[1]) * step, OTHER)
        picture.rect(x + left * step, y + (16 - high) * step, (right - left) * step, (high - low) * step, "white", dash="4 3")
        picture.text(x + (left + right) / 2 * step, y + (16 - (low + high) / 2) * step + 5, name, 12)
    picture.text(x + 140, 28, "boxes, rounded outwards to the node's grid", 12)
    picture.text(x + 140, 46, "(of 255 steps an axis; here 16, and two axes)", 11, fill="#777777")
    eight = lambda words, color: (words, 8, color)
    picture.table(370, 60, [[("origin x y z", 12, BOX), ("exp.", 3, BOX), ("m", 1, LINK)],
                            [("first child", 4, LINK), ("first tri.", 4, LINK), eight("meta", LEAF)],
                            [eight("lower x", OTHER), eight("lower y", OTHER)],
                            [eight("lower z", OTHER), eight("upper x", OTHER)],
                            [eight("upper y", OTHER), eight("upper z", OTHER)]])
    for row, words in enumerate(("m: a bit for each slot with a node", "meta: a byte a slot: a node, a leaf of 1 to 3 triangles,",
                                 "or nothing; lower, upper: a byte a slot")):
        picture.text(370, 280 + 18 * row, words, 12, "start")
    picture.save("compressed8.svg")


if __name__ == "__main__":
    skip()
    pair()
    compressed8()
