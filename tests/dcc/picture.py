"""Makes docs/images/export.png: smoke round a ball, rendered by Blender. Usage: picture.py THURIBLE OUT. Needs bpy; some minutes."""

import importlib.util
import pathlib
import subprocess
import sys

import bpy
import numpy as np

THURIBLE, OUT = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
FRAMES, SIZE, BETWEEN = (26, 44, 61), (240, 360), 8
BALL = ((0.53, 0.5, 0.75), 0.17)
SCENE = f"""
[grid]
cells = [48, 48, 72]
length = 1.5
[time]
steps = 60
dt = 0.0416667
[[emitter]]
from = 0
to = 60
target = 1.0
sphere = {{ center = [0.5, 0.5, 0.12], radius = 0.11 }}
[[obstacle]]
sphere = {{ center = {list(BALL[0])}, radius = {BALL[1]} }}
[flow]
buoyancy = 2.4
[output]
frames = false
"""


def volume():
    """The extension's own part that loads a sequence."""
    folder = ROOT / "std_runner" / "blender"
    spec = importlib.util.spec_from_file_location("thurible_blender", folder / "__init__.py", submodule_search_locations=[str(folder)])
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module.volume.load(bpy.context, OUT / "smoke", (0, 0, 0))


def painted(thing, colour):
    material = bpy.data.materials.new("paint")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*colour, 1)
    thing.data.materials.append(material)


def added(name, data, place, turn):
    thing = bpy.data.objects.new(name, data)
    thing.location, thing.rotation_euler = place, turn
    bpy.context.scene.collection.objects.link(thing)
    return thing


def stage():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for node in volume().data.materials[0].node_tree.nodes:
        if node.type == "PRINCIPLED_VOLUME":
            node.inputs["Density"].default_value = 25
            node.inputs["Color"].default_value = (0.95, 0.95, 0.95, 1)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=BALL[1], location=BALL[0])
    bpy.ops.object.shade_smooth()
    painted(bpy.context.object, (0.7, 0.12, 0.05))
    bpy.ops.mesh.primitive_plane_add(size=20)
    painted(bpy.context.object, (0.25, 0.27, 0.3))
    sun = added("sun", bpy.data.lights.new("sun", "SUN"), (0, 0, 5), (0.7, 0.5, 0.3))
    sun.data.energy, sun.data.angle = 4, 0.05
    scene.camera = added("camera", bpy.data.cameras.new("camera"), (0.5, -3.1, 0.95), (1.5, 0, 0))
    scene.camera.data.lens = 58
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    sky = scene.world.node_tree.nodes["Background"].inputs
    sky["Color"].default_value, sky["Strength"].default_value = (0.35, 0.5, 0.8, 1), 0.7
    scene.render.engine, scene.cycles.samples, scene.cycles.volume_bounces = "CYCLES", 32, 2
    scene.cycles.use_denoising = True
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    return scene


OUT.mkdir(parents=True, exist_ok=True)
(OUT / "scene.toml").write_text(SCENE)
subprocess.run([THURIBLE, "simulate", OUT / "scene.toml", "--precision", "f32", "-o", OUT / "result"], check=True)
subprocess.run([THURIBLE, "export", OUT / "result", "--format", "vdb", "-o", OUT / "smoke"], check=True)
scene = stage()
strip = np.ones((SIZE[1], len(FRAMES) * (SIZE[0] + BETWEEN) - BETWEEN, 4), np.float32)
for place, frame in enumerate(FRAMES):
    scene.frame_set(frame)
    scene.render.filepath = str(OUT / f"{frame}.png")
    bpy.ops.render.render(write_still=True)
    picture = np.array(bpy.data.images.load(scene.render.filepath).pixels[:], np.float32)
    left = place * (SIZE[0] + BETWEEN)
    strip[:, left : left + SIZE[0]] = picture.reshape(SIZE[1], SIZE[0], 4)
image = bpy.data.images.new("strip", strip.shape[1], strip.shape[0])
image.pixels = strip.ravel()
image.filepath_raw, image.file_format = str(ROOT / "docs" / "images" / "export.png"), "PNG"
image.save()
