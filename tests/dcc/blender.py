"""Blender imports the exported sequence and the stage, and renders two frames that differ. Usage: blender.py OUT, after check.py. Needs bpy."""

import json
import pathlib
import sys

import bpy
import numpy as np

OUT = pathlib.Path(sys.argv[1]).resolve()


def fresh():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def imported(export):
    """The volume of an export, as Blender's own importer makes it."""
    files = sorted(path.name for path in (export / "vdb").glob("*.vdb"))
    bpy.ops.object.volume_import(
        filepath=str(export / "vdb" / files[0]), directory=str(export / "vdb"), files=[{"name": name} for name in files],
        relative_path=False, align="WORLD", location=(0, 0, 0),
    )
    return bpy.context.object, files


def box(volume):
    """What of the world the volume takes, over the frame that is shown."""
    shown = volume.evaluated_get(bpy.context.evaluated_depsgraph_get())
    corners = np.array([shown.matrix_world @ __import__("mathutils").Vector(corner) for corner in shown.bound_box])
    return corners.min(0), corners.max(0)


def smoke(result, step):
    """Where the result has smoke, in cells, by axis x, y (and z)."""
    arrays = np.load(result / "result.npz")
    density = (arrays["density"] if "density" in arrays else arrays["captured"])[step]
    density = density.astype(np.float16)
    places = np.argwhere(density.T != 0)
    return places.min(0), places.max(0) + 1


def check_sequence(result, export):
    fresh()
    volume, files = imported(export)
    facts, report = (json.loads(path.read_text()) for path in (export / "export.json", result / "report.json"))
    data = volume.data
    assert data.is_sequence and data.frame_duration == len(files), (data.is_sequence, data.frame_duration)
    assert data.frame_start == 1 and data.frame_offset == 0, (data.frame_start, data.frame_offset)
    scene, side = bpy.context.scene, report["length"] / max(report["cells"])
    scene.render.fps = round(facts["fps"])
    for frame in (1, 3, len(files)):
        scene.frame_set(frame)
        shown = volume.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        shown.grids.load()
        assert shown.grids.frame_filepath.endswith(f"smoke.{frame:04}.vdb"), shown.grids.frame_filepath
        names = {grid.name: grid.data_type for grid in shown.grids}
        assert names["density"] == "FLOAT" and names["velocity"] == "VECTOR_FLOAT", names
        assert shown.velocity_grid == "velocity"
        # z is up: what Blender shows lies where the smoke and the flow of the result are.
        low, high = box(volume)
        least, most = smoke(result, frame - 1)
        sides = np.array(report["cells"]) * side
        axes = [0, 1, 2] if len(sides) == 3 else [0, 2]
        # It shows whole leaves, of 8 cells.
        assert (abs(low[axes]) < 1e-4).all() and (high[axes] <= sides + 7 * side + 1e-4).all(), (low, high, sides)
        assert (low[axes] <= least * side + side).all() and (high[axes] >= most * side - side).all(), (low, high)
    assert min(volume.dimensions) > 0
    return volume


def render(frame, name):
    scene = bpy.context.scene
    scene.frame_set(frame)
    scene.render.filepath = str(OUT / name)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(OUT / name))
    return np.array(image.pixels[:]).reshape(-1, 4)[:, :3]


def check_render(volume, export):
    facts = json.loads((export / "export.json").read_text())
    scene = bpy.context.scene
    material = bpy.data.materials.new("smoke")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, end = nodes.new("ShaderNodeVolumePrincipled"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Density"].default_value = facts["shader_density"]
    material.node_tree.links.new(shader.outputs["Volume"], end.inputs["Volume"])
    volume.data.materials.append(material)
    light = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    light.data.energy = 4
    light.rotation_euler = (0.7, 0.3, 0)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0.5, -2.2, 0.5)
    camera.rotation_euler = (np.pi / 2, 0, 0)
    for thing in (light, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.7, 0.8, 1, 1)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.seed = 8, 0
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 96
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    first, last = render(1, "first.png"), render(7, "last.png")
    seen = (abs(first - first[0]).max(1) > 0.05).mean()
    moved = (abs(first - last).max(1) > 0.05).mean()
    assert seen > 0.01, f"the smoke covers {seen:.4f} of the picture"
    assert moved > 0.005, f"{moved:.4f} of the picture changes"
    return seen, moved


def check_stage(export):
    fresh()
    bpy.ops.wm.usd_import(filepath=str(export / "smoke.usda"), set_frame_range=True)
    volumes = [thing for thing in bpy.data.objects if thing.type == "VOLUME"]
    assert len(volumes) == 1
    scene = bpy.context.scene
    # The rate is that of the file for other programs; Blender takes the range and keeps the rate of its scene.
    assert (scene.frame_start, scene.frame_end) == (1, 7), (scene.frame_start, scene.frame_end)
    assert volumes[0].data.frame_duration == 7
    low, high = box(volumes[0])
    return low, high


result, export = OUT / "deep", OUT / "deep_stage"
volume = check_sequence(result, export)
seen, moved = check_render(volume, export)
check_sequence(OUT / "flat", OUT / "flat_float_none")
plain = check_stage(export)
turned = check_stage(OUT / "deep_all")
# With y up in the file Blender turns the stage itself: the same smoke stands at the same place.
assert np.allclose(plain, turned, atol=1e-3), (plain, turned)
print(f"dcc: Blender {bpy.app.version_string} plays and renders the sequence: {seen:.3f} seen, {moved:.3f} moved")
