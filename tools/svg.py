"""The little of SVG that figures need: shapes on a canvas, with numbers rounded so that the same input gives the same bytes."""

from xml.sax.saxutils import escape

FONT = "font-family='DejaVu Sans, Verdana, sans-serif'"


def number(v):
    text = f"{v:.1f}"
    return text[:-2] if text.endswith(".0") else text


def points(ps):
    return " ".join(f"{number(x)},{number(y)}" for x, y in ps)


class Canvas:
    def __init__(self, width, height):
        self.width, self.height, self.parts = width, height, []
        self.clips = 0
        self.rectangle(0, 0, width, height, fill="#ffffff")

    def add(self, text):
        self.parts.append(text)

    def rectangle(self, x, y, width, height, **style):
        self.add(f"<rect x='{number(x)}' y='{number(y)}' width='{number(width)}' height='{number(height)}'{attributes(style)}/>")

    def polygon(self, ps, **style):
        self.add(f"<polygon points='{points(ps)}'{attributes(style)}/>")

    def line(self, ps, **style):
        self.add(f"<polyline points='{points(ps)}'{attributes({'fill': 'none', **style})}/>")

    def triangles(self, corners, fill):
        """Triangles of one colour, with thin edges."""
        shapes = "".join(f"M{number(a[0])} {number(a[1])}L{number(b[0])} {number(b[1])} {number(c[0])} {number(c[1])}z"
                         for a, b, c in corners)
        self.add(f"<path d='{shapes}' fill='{fill}' stroke='#5d7280' stroke-width='0.45'/>")

    def dots(self, ps, radius, fill, rim=None):
        """Points as discs; with `rim`, a ring of that colour around each."""
        shapes = "".join(f"M{number(x)} {number(y)}h0" for x, y in ps)
        for r, colour in ((radius + 1, rim), (radius, fill)):
            if colour and ps:
                self.add(f"<path d='{shapes}' stroke='{colour}' stroke-width='{number(2 * r)}' stroke-linecap='round'/>")

    def circle(self, x, y, r, **style):
        self.add(f"<circle cx='{number(x)}' cy='{number(y)}' r='{number(r)}'{attributes(style)}/>")

    def text(self, x, y, words, size=13, anchor="start", fill="#333", **style):
        self.add(f"<text x='{number(x)}' y='{number(y)}' font-size='{size}' text-anchor='{anchor}' fill='{fill}' {FONT}"
                 f"{attributes(style)}>{escape(words)}</text>")

    def clip(self, x, y, width, height):
        """What is added until unclip() shows only inside the rectangle."""
        self.clips += 1
        self.add(f"<clipPath id='c{self.clips}'><rect x='{number(x)}' y='{number(y)}' width='{number(width)}' "
                 f"height='{number(height)}'/></clipPath><g clip-path='url(#c{self.clips})'>")

    def unclip(self):
        self.add("</g>")

    def document(self):
        return (f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {self.width} {self.height}' width='{self.width}' "
                f"height='{self.height}'>\n" + "\n".join(self.parts) + "\n</svg>\n")


def attributes(style):
    return "".join(f" {key.replace('_', '-')}='{value}'" for key, value in style.items())
