"""Films of `thurible render` are the pictures that it draws: an MP4 by a real ffmpeg, and an animated WebP, read by others.

usage: check.py PROGRAM FOLDER   (FOLDER is for what it writes; needs numpy, pillow and imageio-ffmpeg)
"""

import os
import shutil
import subprocess
import sys

import imageio_ffmpeg
import numpy
from PIL import Image

SCENE = """
[grid]
cells = [24, 16]
[time]
steps = 6
[source]
circle = { center = [0.25, 0.3], radius = 0.15 }
[[keyframe]]
step = 6
circle = { center = [0.6, 0.35], radius = 0.15 }
[method]
iterations = 5
[output]
frames = false
"""
WIDTH, HEIGHT, STEPS, PACE = 241, 161, 7, 24
# H.264 keeps brightness of every pixel and colours of every other one.
ALIKE = 3.0


def run(*arguments, **more):
    return subprocess.run([str(argument) for argument in arguments], check=True, **more)


def main(program, folder):
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(os.path.join(folder, "bin"))
    ffmpeg = os.path.join(folder, "bin", "ffmpeg")
    os.symlink(imageio_ffmpeg.get_ffmpeg_exe(), ffmpeg)
    path = {**os.environ, "PATH": os.path.join(folder, "bin") + os.pathsep + os.environ["PATH"]}
    scene, result = os.path.join(folder, "scene.toml"), os.path.join(folder, "result")
    with open(scene, "w", encoding="utf-8") as file:
        file.write(SCENE)
    run(program, "solve", scene, "--quiet", "-o", result)
    pictures = os.path.join(folder, "pictures")
    for ending in ["png", "mp4", "webp"]:
        options = ["--size", f"{WIDTH}x{HEIGHT}", "--quiet", "--format", ending, "-o", pictures]
        run(program, "render", result, *options, env=path)
    frames = [Image.open(os.path.join(pictures, f"frame_{step:04}.png")).convert("RGB") for step in range(STEPS)]
    frames = [numpy.asarray(frame, dtype=int) for frame in frames]
    check_mp4(ffmpeg, os.path.join(pictures, "render.mp4"), frames)
    check_webp(os.path.join(pictures, "render.webp"), frames)
    print("films: ok")


def check_mp4(ffmpeg, path, frames):
    size = (HEIGHT + HEIGHT % 2, WIDTH + WIDTH % 2, 3)
    raw = run(ffmpeg, "-loglevel", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-", stdout=subprocess.PIPE).stdout
    film = numpy.frombuffer(raw, dtype=numpy.uint8).reshape(-1, *size).astype(int)
    assert len(film) == STEPS, f"{len(film)} pictures"
    for step, (shown, frame) in enumerate(zip(film, frames)):
        apart = numpy.abs(shown[:HEIGHT, :WIDTH] - frame).mean()
        assert apart < ALIKE, f"step {step} is {apart} levels off"
    said = run(ffmpeg, "-hide_banner", "-i", path, "-f", "null", "-", stderr=subprocess.PIPE, text=True).stderr
    assert "yuv420p(tv, bt709" in said, f"colours of no high definition: {said}"
    # A control: another step is further away than the right one.
    assert numpy.abs(film[-1, :HEIGHT, :WIDTH] - frames[0]).mean() > ALIKE


def check_webp(path, frames):
    film = Image.open(path)
    assert (film.n_frames, film.size, film.info["loop"]) == (STEPS, (WIDTH, HEIGHT), 0), film.info
    shown = 0
    for step, frame in enumerate(frames):
        film.seek(step)
        film.load()
        shown += film.info["duration"]
        assert abs(shown - 1000 * (step + 1) / PACE) <= 0.5, f"step {step} ends after {shown} ms"
        assert (numpy.asarray(film.convert("RGB")) == frame).all(), f"step {step} has other pixels"


if __name__ == "__main__":
    main(*sys.argv[1:])
