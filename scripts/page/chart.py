# SPDX-License-Identifier: BSD-2-Clause
"""Charts as SVG text. Colours are classes of page.css, so that they follow the reader's light or dark theme."""
import html
import math

WIDTH, HEIGHT = 340, 236
LEFT, RIGHT, TOP, BOTTOM = 56, 8, 8, 38
MAX_POINTS = 500


def nice_ticks(low, high, count):
    """At most about `count` round numbers from low to high."""
    if not high > low:
        return [low]
    raw = (high - low) / max(count, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(power * factor for factor in (1, 2, 2.5, 5, 10) if power * factor >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [index * step for index in range(first, math.floor(high / step + 1e-9) + 1)]


def tick_text(value):
    """A tick's number without needless digits, with a true minus."""
    return f"{0.0 if abs(value) < 1e-12 else value:.4g}".replace("-", "\u2212")


def padded(values, share=0.06, low=None):
    """Range of the values that are finite, with a margin; `low` fixes its lower end."""
    finite = [value for value in values if math.isfinite(value)] or [0.0, 1.0]
    least, most = min(finite), max(finite)
    margin = share * (most - least) or 0.5 * abs(most) or 1.0
    return (least - margin if low is None else low), most + margin


def thinned(xs, ys, most=MAX_POINTS):
    """Points of a curve, of long ones the least and the greatest of each stretch."""
    points = [(x, y) for x, y in zip(xs, ys) if math.isfinite(y)]
    if len(points) <= most:
        return points
    size = math.ceil(2 * len(points) / most)
    kept = []
    for begin in range(0, len(points), size):
        part = points[begin:begin + size]
        kept += sorted({min(part, key=lambda p: p[1]), max(part, key=lambda p: p[1])})
    return kept


class Chart:
    """One pair of axes within a picture.

    x, y: ranges. top, height: the place within the picture, labels included. time: has a cursor that page.js moves.
    """

    def __init__(self, x, y, x_label="", y_label="", top=0, height=HEIGHT, log_y=False, time=False, left=LEFT,
                 y_names=None, x_names=None):
        self.x, self.y, self.log_y = x, y, log_y
        self.box = (left, top + TOP, WIDTH - RIGHT, top + height - (BOTTOM if x_label else 8))
        self.parts = []
        self.axes(x_label, y_label, y_names, x_names)
        if time:
            x0, y0, x1, y1 = self.box
            self.parts.append(f'<line class="now" x1="-9" x2="-9" y1="{y0}" y2="{y1}" data-x0="{x0}" data-x1="{x1}" '
                              f'data-t0="{x[0]:.3f}" data-t1="{x[1]:.3f}"/>')

    def px(self, value):
        """Place of an x in the picture."""
        x0, _, x1, _ = self.box
        return x0 + (x1 - x0) * (value - self.x[0]) / ((self.x[1] - self.x[0]) or 1.0)

    def py(self, value):
        """Place of a y in the picture, kept within the axes but for a little."""
        _, y0, _, y1 = self.box
        low, high = self.y
        if self.log_y:
            value, low, high = (math.log10(max(v, 1e-12)) for v in (value, low, high))
        return min(max(y1 - (y1 - y0) * (value - low) / ((high - low) or 1.0), y0 - 3), y1 + 3)

    def axes(self, x_label, y_label, y_names, x_names):
        """Grid, ticks and labels."""
        x0, y0, x1, y1 = self.box
        if self.log_y:
            low, high = (round(math.log10(v)) for v in self.y)
            ticks = [10.0 ** power for power in range(low, high + 1)]
        else:
            ticks = nice_ticks(*self.y, max(3, (y1 - y0) // 40))
        if y_names is None:
            y_names = [(value, tick_text(value)) for value in ticks]
        for value, name in y_names:
            y = self.py(value)
            self.parts.append(f'<line class="grid" x1="{x0}" x2="{x1}" y1="{y:.1f}" y2="{y:.1f}"/>'
                              f'<text x="{x0 - 5}" y="{y + 4:.1f}" text-anchor="end">{html.escape(name)}</text>')
        if x_names is None:
            x_names = [(value, tick_text(value)) for value in nice_ticks(*self.x, 5)]
        for value, name in x_names:
            self.parts.append(f'<text x="{self.px(value):.1f}" y="{y1 + 15}" text-anchor="middle">'
                              f'{html.escape(name)}</text>')
        self.parts.append(f'<line class="axis" x1="{x0}" x2="{x1}" y1="{y1}" y2="{y1}"/>')
        if x_label:
            self.parts.append(f'<text class="label" x="{(x0 + x1) / 2}" y="{y1 + 31}" text-anchor="middle">'
                              f'{html.escape(x_label)}</text>')
        if y_label:
            self.parts.append(f'<text class="label" transform="translate(11 {(y0 + y1) / 2}) rotate(-90)" '
                              f'text-anchor="middle">{html.escape(y_label)}</text>')

    def line(self, xs, ys, style, thin=True):
        """A curve of the class `style`."""
        points = thinned(xs, ys) if thin else list(zip(xs, ys))
        text = " ".join(f"{self.px(x):.1f},{self.py(y):.1f}" for x, y in points)
        self.parts.append(f'<polyline class="curve {style}" points="{text}"/>')

    def points(self, xs, ys, style):
        """Small marks, of very many the least and the greatest of each stretch."""
        text = "".join(f"M{self.px(x):.1f} {self.py(y):.1f}h0" for x, y in thinned(xs, ys, 4 * MAX_POINTS))
        self.parts.append(f'<path class="curve marks {style}" d="{text}"/>')

    def coloured_line(self, xs, ys, shades):
        """A curve whose pieces have the colour scale's classes m0 to m7, by `shades` in [0, 1]."""
        step = max(1, len(xs) // (2 * MAX_POINTS))
        begin = 0
        classes = [min(7, int(8 * shade)) for shade in shades]
        last = len(xs) - 1
        for index in range(1, last + 1):
            if classes[index] != classes[begin] or index == last:
                chosen = list(range(begin, index, step)) + [index]
                self.line([xs[i] for i in chosen], [ys[i] for i in chosen], f"map m{classes[begin]}", thin=False)
                begin = index

    def band(self, xs, lows, highs, style):
        """An area between two curves."""
        upper, lower = thinned(xs, highs), thinned(xs, lows)
        text = " ".join(f"{self.px(x):.1f},{self.py(y):.1f}" for x, y in upper + lower[::-1])
        self.parts.append(f'<polygon class="band {style}" points="{text}"/>')

    def bar(self, x0, y0, x1, y1, style, title=""):
        """A rectangle between two corners in the units of the axes."""
        left, right = sorted((self.px(x0), self.px(x1)))
        upper, lower = sorted((self.py(y0), self.py(y1)))
        inside = f"<title>{html.escape(title)}</title>" if title else ""
        self.parts.append(f'<rect class="bar {style}" x="{left:.1f}" y="{upper:.1f}" width="{right - left:.1f}" '
                          f'height="{lower - upper:.1f}">{inside}</rect>')

    def dot(self, x, y, style, radius=3.5):
        """A mark."""
        self.parts.append(f'<circle class="dot {style}" cx="{self.px(x):.1f}" cy="{self.py(y):.1f}" r="{radius}"/>')

    def text(self, x, y, text, dx=0, style=""):
        """Words to the right of a place in the units of the axes."""
        self.parts.append(f'<text class="{style}" x="{self.px(x) + dx:.1f}" y="{self.py(y) + 3:.1f}">'
                          f'{html.escape(text)}</text>')

    def box_plot(self, x, width, quantiles, style):
        """Box from the first to the third quartile with the median; whiskers to the 5th and the 95th percentile."""
        p5, p25, p50, p75, p95 = quantiles
        middle = self.px(x)
        half = abs(self.px(x + width / 2) - middle)
        self.parts.append(f'<path class="curve {style}" d="M{middle:.1f} {self.py(p5):.1f}V{self.py(p25):.1f}'
                          f'M{middle:.1f} {self.py(p75):.1f}V{self.py(p95):.1f}"/>')
        self.bar(x - width / 2, p25, x + width / 2, p75, f"box {style}")
        y = self.py(p50)
        self.parts.append(f'<path class="curve median {style}" d="M{middle - half:.1f} {y:.1f}H{middle + half:.1f}"/>')


def picture(charts, title, height=HEIGHT):
    """The SVG text of one or several charts; `title` is for readers who do not see it."""
    inside = "".join(part for chart in charts for part in chart.parts)
    return (f'<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{html.escape(title)}">{inside}</svg>')
