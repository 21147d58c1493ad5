"""Lines across the borders between drawn classes, compiled: see `compare.borders`."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from abs_engine.core.compiled import INNER, LOOP

MOST = 16  # longest line to either side, drawn pixels
_REACH = 2.55  # pixels around a border's middle that tell its normal
_PARTED = 0.15  # what each pixel must gain on the average for lips to be parted there
_inlined: Any = numba.njit(**INNER, error_model="numpy", fastmath=True, forceinline=True)
"""Inlined, as a process that compiles these and one that reads them from the cache would else call
different copies of a loop, whose last digits differ."""
_compiled: Any = numba.njit(**LOOP, error_model="numpy", fastmath=True)
_NONE = np.int64(0)  # not the literal, for which numba would compile a loop again


@_compiled
def total(of, shown, maps):
    """The sum of the maps (G, H, W) of the groups that an image of classes (H, W) shows."""
    out = 0.0
    for y in range(shown.shape[0]):
        for x in range(shown.shape[1]):
            out += maps[of[shown[y, x]], y, x]
    return out


@_inlined
def pairs(shown):
    """Number of neighbouring pixels of an image (H, W) that differ."""
    height, width = shown.shape
    count = 0
    for y in range(height):
        for x in range(1, width):
            count += 1 if shown[y, x] != shown[y, x - 1] else 0
    for y in range(1, height):
        for x in range(width):
            count += 1 if shown[y, x] != shown[y - 1, x] else 0
    return count


@_inlined
def normal_of(group, y, x, mx, my, first, second):
    """Unit normal from group `first` to `second` about a border; 0, 0 where there is none."""
    height, width = group.shape
    nx = ny = 0.0
    for j in range(max(y - 2, 0), min(y + 4, height)):
        for i in range(max(x - 2, 0), min(x + 4, width)):
            ex, ey = i - mx, j - my
            if ex * ex + ey * ey > _REACH * _REACH:
                continue
            here = group[j, i]
            sign = 1.0 if here == second else (-1.0 if here == first else 0.0)
            nx += sign * ex
            ny += sign * ey
    size = np.sqrt(nx * nx + ny * ny)
    if size < 1e-6:
        return 0.0, 0.0
    return nx / size, ny / size


@_inlined
def free_length(group, mx, my, nx, ny, own, reach):
    """Steps along (nx, ny) that stay in the group `own`, at most `reach`."""
    height, width = group.shape
    for s in range(1, reach + 1):
        i, j = int(np.floor(mx + nx * s + 0.5)), int(np.floor(my + ny * s + 0.5))
        if i < 1 or j < 1 or i >= width - 1 or j >= height - 1:
            return s - 1
        if s > 1 and group[j, i] != own:
            return s - 1
    return reach


@_inlined
def sampled_at(plane, x, y):
    """A plane (H, W) between its pixels."""
    height, width = plane.shape
    i, j = int(x), int(y)
    if x < 0 or y < 0 or i >= width - 1 or j >= height - 1:
        return 0.0
    a, b = x - i, y - j
    above = (1 - a) * plane[j, i] + a * plane[j, i + 1]
    below = (1 - a) * plane[j + 1, i] + a * plane[j + 1, i + 1]
    return (1 - b) * above + b * below


@_inlined
def gain_along(profile, low, high):
    """Place on a line where the border gains most by moving, whole steps, and the gain."""
    best, at, total = 0.0, 0, 0.0
    for s in range(1, high + 1):
        total += 0.5 * (profile[MOST + s - 1] + profile[MOST + s])
        if total > best:
            best, at = total, s
    total = 0.0
    for s in range(1, low + 1):
        total -= 0.5 * (profile[MOST - s + 1] + profile[MOST - s])
        if total > best:
            best, at = total, -s
    return best, at


@_inlined
def crossing(profile, at, low, high):
    """Place where the profile crosses 0 next to the step `at`."""
    for s in (at - 1, at):
        if s < -low or s + 1 > high:
            continue
        one, other = profile[MOST + s], profile[MOST + s + 1]
        if one > 0 and other <= 0:
            return s + one / (one - other)
    return float(at)


@_inlined
def model_of(profile, low, high, floor):
    """Gain per pixel of a border's motion and its curvature, of the profile's integral.

    Where the best place is steps away the parabola through it and here (a secant) takes the place
    of the local slope.
    """
    best, at = gain_along(profile, low, high)
    if at == 0 or best < 0.02:
        up, down = min(high, 2), min(low, 2)
        curve = floor
        if up + down > 0:
            curve = max((profile[MOST - down] - profile[MOST + up]) / (up + down), floor)
        most = 2.0 * curve
        return min(max(profile[MOST], -most), most), curve
    away = crossing(profile, at, low, high)
    if away == 0.0:
        return 0.0, floor
    curve = min(max(2.0 * best / (away * away), floor), 1.0)
    return curve * away, curve


@_inlined
def slope_of(profile, low, high, floor):
    """Gain per pixel where the border is, and its curvature over two pixels to either side."""
    up, down = min(high, 2), min(low, 2)
    curve = floor
    if up + down > 0:
        curve = max((profile[MOST - down] - profile[MOST + up]) / (up + down), floor)
    gain = profile[MOST]
    if low > 0 and high > 0:
        gain = 0.25 * (profile[MOST - 1] + 2 * profile[MOST] + profile[MOST + 1])
    return gain, curve


@_inlined
def profile_of(maps, first, second, mx, my, nx, ny, low, high, profile):
    """Gain of a pixel that turns from group `second` to `first`, at whole steps of the line."""
    for s in range(-low, high + 1):
        px, py = mx + nx * s, my + ny * s
        profile[MOST + s] = sampled_at(maps[first], px, py) - sampled_at(maps[second], px, py)


@_inlined
def put(out, places, count, nx, ny, gain, curve, y, x):
    """One border more."""
    out[count, 0], out[count, 1], out[count, 2], out[count, 3] = nx, ny, gain, curve
    places[count, 0], places[count, 1] = y, x
    return count + 1


@_inlined
def line_across(labels, y, x, y2, x2, reach):
    """Middle and normal between two neighbours, the border's length, and how far either side goes.

    The length is 0 where there is no normal.
    """
    first, second = labels[y, x], labels[y2, x2]
    mx, my = 0.5 * (x + x2), 0.5 * (y + y2)
    nx, ny = normal_of(labels, y, x, mx, my, first, second)
    length = abs(nx) if y == y2 else abs(ny)
    if length < 0.05:
        return mx, my, nx, ny, 0.0, 0, 0
    low = free_length(labels, mx, my, -nx, -ny, first, reach)
    high = free_length(labels, mx, my, nx, ny, second, reach)
    return mx, my, nx, ny, length, low, high


@_inlined
def border(group, maps, depth, y, x, y2, x2, reach, floor, local, profile, out, places, count):
    """The border between two neighbouring pixels of different groups."""
    mx, my, nx, ny, length, low, high = line_across(group, y, x, y2, x2, reach)
    if length == 0.0:
        return count
    first, second = np.int64(group[y, x]), np.int64(group[y2, x2])
    profile_of(maps, first, second, mx, my, nx, ny, low, high, profile)
    if local:
        gain, curve = slope_of(profile, low, high, floor)
    else:
        gain, curve = model_of(profile, low, high, floor)
    if depth[y, x] > depth[y2, x2]:
        y, x = y2, x2
    return put(out, places, count, nx, ny, gain * length, curve * length, y, x)


@_inlined
def seam(
    part, maps, lip, lip2, inside, y, x, y2, x2, reach, floor, profile, out, places, count
):  # fmt: skip
    """Border at which two parts of the lips meet: each may draw back and show what is behind.

    `lip` and `lip2` are the groups of the two, which may be one.
    """
    mx, my, nx, ny, length, low, high = line_across(part, y, x, y2, x2, reach)
    if length == 0.0:
        return count
    profile_of(maps, inside, lip2, mx, my, nx, ny, _NONE, high, profile)
    best, at = gain_along(profile, _NONE, high)
    if best > _PARTED * at > 0:
        gain, curve = model_of(profile, _NONE, high, floor)
        count = put(out, places, count, nx, ny, gain * length, curve * length, y2, x2)
    profile_of(maps, lip, inside, mx, my, nx, ny, low, _NONE, profile)
    best, at = gain_along(profile, low, _NONE)
    if best > -_PARTED * at > 0:
        gain, curve = model_of(profile, low, _NONE, floor)
        count = put(out, places, count, nx, ny, gain * length, curve * length, y, x)
    return count


@_inlined
def lines(group, part, maps, depth, inside, reach, floor, local, out, places):
    """Every border of a drawing, in `out` and `places`; how many there are.

    `group` and `part` are (H, W), 0 where nothing is drawn, or nothing that may part. `out` (K, 4)
    holds normal x, y, and gain and curvature times the border's length; `places` (K, 2) row and
    column of the pixel whose surface is in front, whose outline the border is.
    """
    height, width = group.shape
    profile = np.zeros(2 * MOST + 1)
    count = _NONE
    for y in range(1, height - 2):
        for x in range(1, width - 2):
            here, own = group[y, x], part[y, x]
            if here == 0 or (
                here == group[y, x + 1] and here == group[y + 1, x]
                and own == part[y, x + 1] and own == part[y + 1, x]
            ):  # fmt: skip
                continue  # as most pixels are
            for axis in range(2):
                y2, x2 = (y, x + 1) if axis == 0 else (y + 1, x)
                if group[y, x] == 0 or group[y2, x2] == 0:
                    continue
                if group[y, x] != group[y2, x2]:
                    count = border(
                        group, maps, depth, y, x, y2, x2, reach, floor, local, profile, out,
                        places, count,
                    )  # fmt: skip
                if not local and 0 < part[y, x] != part[y2, x2] > 0:
                    count = seam(
                        part, maps, np.int64(group[y, x]), np.int64(group[y2, x2]), inside,
                        y, x, y2, x2, reach, floor, profile, out, places, count,
                    )  # fmt: skip
    return count


@_compiled
def borders(shown, of, part_of, maps, facet, depth, bary, inside, reach, floor, local):
    """Every border of a drawing of classes (H, W).

    Facet (K,), barycentrics (K, 3), normal (K, 2), gain (K,) and curvature (K,) times its length.
    """
    height, width = shown.shape
    group, part = np.empty((height, width), np.int32), np.empty((height, width), np.int32)
    for y in range(height):
        for x in range(width):
            group[y, x], part[y, x] = of[shown[y, x]], part_of[shown[y, x]]
    most = 3 * pairs(shown)
    out, places = np.empty((most, 4)), np.empty((most, 2), np.int64)
    count = lines(group, part, maps, depth, inside, reach, floor, local, out, places)
    of_facet, weights = np.empty(count, np.int32), np.empty((count, 3))
    for k in range(count):
        y, x = places[k]
        of_facet[k] = facet[y, x] - 1
        for c in range(3):
            weights[k, c] = bary[y, x, c]
    return of_facet, weights, out[:count, :2], out[:count, 2], out[:count, 3]
