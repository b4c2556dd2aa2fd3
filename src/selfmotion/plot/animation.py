"""The arm moving on its path, as GIF and MP4."""

from __future__ import annotations

import io
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from selfmotion._checks import integer, number
from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.domain import angle_domain
from selfmotion.errors import InvalidInputError, MissingExtraError
from selfmotion.plot.domain import draw_domain
from selfmotion.plot.obstacles import draw_obstacles, in_view
from selfmotion.plot.plane import draw_base, frame
from selfmotion.plot.style import COLORS, GREY, INK, figure
from selfmotion.problem import Problem

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray
    from PIL.Image import Image

    Pixels = NDArray[np.uint8]

MOST_FRAMES = 1500
_DPI = 100
# Size [inch] with the angle domain and without it; the left part's share with it.
_WIDE, _NARROW = (7.0, 3.4), (4.6, 4.4)
# The trace fades over this part of the time; its number of segments, and those of a curve.
_FADE, _SEGMENTS, _CURVE = 0.25, 48, 601
_PALETTE, _PAPER = 96, 240
_HUNDREDTH = 100  # GIF counts time in hundredths of a second
_ON_BRANCH = 1e-6


class Motion(NamedTuple):
    """A sampled joint motion, straight between its rows.

    Attributes
    ----------
    r : array, shape (k,)
        Path parameters, not descending.
    q : array, shape (k, n)
        Joint angles [rad].
    """

    r: FloatArray
    q: FloatArray

    def at(self, r: FloatArray) -> FloatArray:
        """Return the joint angles at path parameters `r`, shape (len(r), n)."""
        return np.stack([np.interp(r, self.r, column) for column in self.q.T], axis=-1)


class Animation:
    """The arm on its path with a fading trace; for one redundant degree also a dot in the angle domain.

    Parameters
    ----------
    problem : Problem
    r : array, shape (k,)
        Path parameters, not descending.
    q : array, shape (k, n)
        Joint angles [rad]. Joints move on straight lines between the rows; a free joint takes the short way.
    seconds : float
        Duration. The path parameter is linear in time.
    fps : int
        Frames per second.

    Raises
    ------
    InvalidInputError
        If duration or rate are out of range.
    """

    def __init__(self, problem: Problem, r: FloatArray, q: FloatArray, seconds: float = 6.0, fps: int = 25) -> None:
        self.fps = integer("--fps", fps, 1, 50)
        self.seconds = number("--seconds", seconds, 0.1, 600.0)
        self.count = max(2, round(self.seconds * self.fps))
        if self.count > MOST_FRAMES:
            reason = f"times --fps exceeds {MOST_FRAMES} frames"
            raise InvalidInputError("--seconds", reason, "lower one of them", seconds)
        self.problem = problem
        free = ~problem.arm.limits.limited
        self.motion = Motion(r, np.where(free, np.unwrap(q, axis=0), q))

    def frames(self, chosen: Iterable[int] | None = None) -> Iterator[Pixels]:
        """Yield the `chosen` frames, or all, as arrays of shape (height, width, 3); only what moves is drawn anew."""
        r = np.linspace(self.motion.r[0], self.motion.r[-1], self.count)
        with_domain = self.problem.arm.n_u == 1
        width, height = _WIDE if with_domain else _NARROW
        with figure(width=width, height=height, columns=1 + with_domain) as (canvas, axes):
            canvas.set_dpi(_DPI)
            parts: list[_Arm | _Dot] = [_Arm(axes[0], self.problem, self.motion, r)]
            if with_domain:
                parts.append(_Dot(axes[1], self.problem, self.motion, r))
            yield from _redrawn(canvas, parts, range(self.count) if chosen is None else chosen)

    def gif(self) -> bytes:
        """Return the animation as GIF; the same motion gives the same bytes."""
        from PIL import Image

        palette = _palette(np.vstack(list(self.frames((0, self.count // 2, self.count - 1)))))
        pictures = (
            Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE) for pixels in self.frames()
        )
        ends = np.rint(np.arange(1, self.count + 1) * _HUNDREDTH / self.fps).astype(int)
        durations = (np.diff(ends, prepend=0) * (1000 // _HUNDREDTH)).tolist()
        buffer = io.BytesIO()
        next(pictures).save(
            buffer, format="GIF", save_all=True, append_images=pictures, duration=durations, loop=0, optimize=False
        )
        return buffer.getvalue()

    def mp4(self) -> bytes:
        """Return the animation as MP4 (H.264); the same motion and encoder give the same bytes.

        Raises
        ------
        MissingExtraError
            If there is no encoder.
        """
        program = encoder()
        pictures = self.frames()
        first = next(pictures)
        height, width = first.shape[0] // 2 * 2, first.shape[1] // 2 * 2  # the format wants even numbers
        exact = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", "-threads", "1"]
        source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(self.fps), "-i", "-"]
        coding = ["-an", "-c:v", "libx264", "-preset", "medium", "-crf", "20", "-pix_fmt", "yuv420p"]
        with tempfile.TemporaryDirectory(prefix="selfmotion-") as folder:
            target = Path(folder) / "animation.mp4"
            command = [program, "-v", "error", "-y", *source, *coding, *exact, "-movflags", "+faststart", str(target)]
            with tempfile.TemporaryFile() as said:
                with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=said, stderr=said) as process:
                    assert process.stdin is not None
                    try:
                        for pixels in (first, *pictures):
                            process.stdin.write(np.ascontiguousarray(pixels[:height, :width]).tobytes())
                        process.stdin.close()
                    except BrokenPipeError:
                        pass  # it has stopped, and says why
                said.seek(0)
                words = " ".join(said.read().decode(errors="replace").split())
            if process.returncode:
                remedy = "pip install 'selfmotion[animation]' brings an encoder that works"
                raise InvalidInputError("--format", f"mp4 failed: {words[-200:]}", remedy)
            return target.read_bytes()


def encoder() -> str:
    """Return the program that writes MP4: the one of the package imageio-ffmpeg, or an ffmpeg on the PATH.

    Raises
    ------
    MissingExtraError
        If there is neither.
    """
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        found = shutil.which("ffmpeg")
    if found is None:
        remedy = "pip install 'selfmotion[animation]', or ask for gif only"
        raise MissingExtraError("--format", "needs the package imageio-ffmpeg or the program ffmpeg", remedy, "mp4")
    return found


class _Arm:
    """The left part: path, arm, trace."""

    def __init__(self, axes: Axes, problem: Problem, motion: Motion, r: FloatArray) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.colors import to_rgb

        arm = problem.arm
        self.r = r
        self.chains = arm.joint_positions(motion.at(r))
        span = r[-1] - r[0]
        # The trace ends at each frame and begins a quarter of the time before it.
        back = np.linspace(-_FADE, 0.0, _SEGMENTS + 1) * span
        self.traces = arm.forward(motion.at(np.maximum(r[:, None] + back, r[0]).ravel())).reshape(len(r), -1, 2)
        x = problem.path(problem.path.grid(800))
        axes.plot(x[:, 0], x[:, 1], color=GREY, linewidth=0.9)
        draw_obstacles(axes, arm)
        draw_base(axes)
        frame(axes, np.vstack([self.chains.reshape(-1, 2), x, [[0.0, 0.0]], in_view(arm)]), margin=0.08)
        colors = np.tile([*to_rgb(COLORS[0]), 1.0], (_SEGMENTS, 1))
        colors[:, 3] = np.linspace(0.0, 1.0, _SEGMENTS)
        self.trace = LineCollection([], colors=colors, linewidths=2.6, animated=True, zorder=3)
        axes.add_collection(self.trace, autolim=False)
        (self.links,) = axes.plot([], [], "-o", color=INK, linewidth=2.2, markersize=4.0, animated=True, zorder=4)
        (self.tool,) = axes.plot([], [], "o", color=COLORS[1], markersize=6.0, animated=True, zorder=5)
        self.label = axes.text(0.02, 0.98, "", transform=axes.transAxes, va="top", animated=True, zorder=6)
        axes.set_title("arm and path")
        self.axes = axes

    def move(self, k: int) -> list[Artist]:
        """Put everything where it is in frame `k`; return what to draw."""
        chain, trace = self.chains[k], self.traces[k]
        self.links.set_data(chain[:, 0], chain[:, 1])
        self.tool.set_data(chain[-1:, 0], chain[-1:, 1])
        self.trace.set_segments(np.stack([trace[:-1], trace[1:]], axis=1))  # type: ignore[arg-type]
        self.label.set_text(f"r = {self.r[k]:.2f}")
        return [self.trace, self.links, self.tool, self.label]


class _Dot:
    """The right part: the angle domain, and where the arm is in it."""

    def __init__(self, axes: Axes, problem: Problem, motion: Motion, r: FloatArray) -> None:
        arm = problem.arm
        q = motion.at(r)
        branch = int(np.bincount(arm.branch_of(q)).argmax())  # where the motion spends most of its time
        self.on_branch = arm.is_on_branch(q, branch, _ON_BRANCH)
        curve = np.linspace(motion.r[0], motion.r[-1], _CURVE)
        u = np.unwrap(arm.u_of(motion.at(curve))[:, 0])
        _draw_domain(axes, problem, branch, curve, u)
        self.r = r
        # The dot goes where the drawing's window shows the curve.
        u = u + TAU * np.rint((np.mean(axes.get_ylim()) - np.mean(u)) / TAU)
        self.u = np.interp(r, curve, u)
        (self.dot,) = axes.plot([], [], "o", color=COLORS[1], markersize=6.0, animated=True, zorder=5)
        self.axes = axes

    def move(self, k: int) -> list[Artist]:
        """Put the dot where it is in frame `k`, hollow on the other branch; return what to draw."""
        self.dot.set_data(self.r[k : k + 1], self.u[k : k + 1])
        self.dot.set_markerfacecolor(COLORS[1] if self.on_branch[k] else "white")
        return [self.dot]


def _draw_domain(axes: Axes, problem: Problem, branch: int, r: FloatArray, u: FloatArray) -> None:
    """Draw the angle domain with the motion's curve."""
    draw_domain(axes, angle_domain(problem.arm, problem.path), branch, {"motion": (r, u)})


def _redrawn(canvas: Figure, parts: list[Any], chosen: Iterable[int]) -> Iterator[Pixels]:
    """Draw what stands still once, then yield frame by frame with what moves on top."""
    agg: Any = canvas.canvas
    agg.draw()
    canvas.set_layout_engine("none")  # nothing may shift from here on
    still = agg.copy_from_bbox(canvas.bbox)
    for k in chosen:
        agg.restore_region(still)
        for part in parts:
            for artist in part.move(k):
                part.axes.draw_artist(artist)
        yield np.asarray(agg.buffer_rgba())[..., :3].copy()


def _palette(pixels: Pixels) -> Image:
    """Return one palette for all frames, from those in `pixels`, so that nothing flickers."""
    from PIL import Image

    # Of the nearly white, paper alone is kept: the many greys at the rims of lines would tint it.
    inked = pixels[pixels.min(axis=-1) < _PAPER]
    palette = Image.fromarray(inked[None]).quantize(_PALETTE - 1, method=Image.Quantize.MEDIANCUT)
    palette.putpalette([255, 255, 255, *(palette.getpalette() or [])[: 3 * (_PALETTE - 1)]])
    return palette
