# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene of thurible from objects of Blender: meshes beside a file that names them."""

import contextlib
import json
import pathlib

import bpy
from mathutils import Vector

# The key of a shape that is a mesh, and what says that its lengths are those of the scene, z up.
MESH = "mesh"
PLACED = 'fit = "world", up = "z"'
LEAST_CELLS = 4
# The files of a scene: what is solved, and where in Blender its smoke belongs.
SCENE, PLACE = "scene.toml", "place.json"


class Refused(Exception):
    """What the user has to change, in a sentence."""


def meshes(collection):
    """Objects of a collection that have a surface."""
    if collection is None:
        return []
    kinds = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
    return [thing for thing in collection.all_objects if thing.type in kinds]


def domain(settings):
    """The low corner of the box and its sides, in world units, at the frame that is shown."""
    if settings.domain is None:
        raise Refused("Choose a domain: an object whose bounding box is where the smoke may be")
    corners = [settings.domain.matrix_world @ Vector(corner) for corner in settings.domain.bound_box]
    low = [min(corner[axis] for corner in corners) for axis in range(3)]
    high = [max(corner[axis] for corner in corners) for axis in range(3)]
    sides = [high[axis] - low[axis] for axis in range(3)]
    if min(sides) <= 0:
        raise Refused(f"The domain {settings.domain.name} is flat; choose a box")
    return low, sides


def grid(settings):
    """The low corner, the longest side and the cells."""
    low, sides = domain(settings)
    longest = max(sides)
    side = longest / settings.resolution
    cells = [max(LEAST_CELLS, round(length / side)) for length in sides]
    cells[sides.index(longest)] = settings.resolution
    return low, longest, cells


def frame_rate(scene):
    return scene.render.fps / scene.render.fps_base


@contextlib.contextmanager
def shown(things):
    """Shows objects and their collections for as long as they are read: of hidden ones Blender evaluates no modifiers."""
    collections = {found for thing in things for found in thing.users_collection}
    collections |= {above for above in bpy.data.collections if collections & set(above.children_recursive)}
    hidden = [found for found in (*things, *collections) if found.hide_viewport]
    for found in hidden:
        found.hide_viewport = False
    try:
        yield
    finally:
        for found in hidden:
            found.hide_viewport = True


def write_obj(path, things, low):
    """Writes the surfaces of objects, as modifiers leave them, relative to the corner `low`."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    count, lines = 0, []
    for thing in things:
        evaluated = thing.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh()
        mesh.calc_loop_triangles()
        for vertex in mesh.vertices:
            x, y, z = evaluated.matrix_world @ vertex.co
            lines.append(f"v {x - low[0]:.9g} {y - low[1]:.9g} {z - low[2]:.9g}")
        for triangle in mesh.loop_triangles:
            lines.append("f " + " ".join(str(1 + count + index) for index in triangle.vertices))
        count += len(mesh.vertices)
        evaluated.to_mesh_clear()
    if not lines:
        raise Refused(f"{', '.join(thing.name for thing in things)} has no faces; choose objects with a surface")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def shape(name):
    """A shape as lines of a table."""
    return f"{MESH} = {json.dumps(name)}\n{PLACED}".replace(", ", "\n")


def by_frame(settings, scene):
    """The objects of the keyframes by their frames, ascending."""
    found = {}
    for thing in meshes(settings.keyframes):
        frame = thing.thurible_frame or scene.frame_end
        found.setdefault(frame, []).append(thing)
    if not found:
        raise Refused("Choose a collection of keyframes with at least one object")
    for frame, things in found.items():
        if not scene.frame_start + 2 <= frame <= scene.frame_end:
            raise Refused(
                f"{things[0].name} is a keyframe at frame {frame}; choose one from {scene.frame_start + 2} to {scene.frame_end}"
            )
    return dict(sorted(found.items()))


def emitters(settings, scene):
    """The objects that emit, by the frame that they do so up to, ascending."""
    found = {}
    for thing in meshes(settings.emitters):
        until = min(thing.thurible_until or scene.frame_end, scene.frame_end)
        if until <= scene.frame_start:
            raise Refused(f"{thing.name} emits until frame {until}; choose one after {scene.frame_start}")
        found.setdefault(until, []).append(thing)
    return dict(sorted(found.items()))


def weight(settings, length, dt):
    """The weight of force in the scene's units: that of a box and steps of length 1, times dt^4 / length^2, since a force is an acceleration."""
    return settings.force_weight * dt**4 / length**2


def write(context, folder):
    """Writes scene.toml, its meshes and where its smoke belongs into `folder`; the answer is the path of the scene."""
    scene, settings = context.scene, context.scene.thurible
    folder = pathlib.Path(folder)
    keyframes, sources, solids = by_frame(settings, scene), meshes(settings.source), meshes(settings.solids)
    emitting = emitters(settings, scene)
    if not sources and not emitting:
        raise Refused("Choose a collection for the source, the smoke at the first frame, or one for emitters, with at least one object")
    steps, dt = scene.frame_end - scene.frame_start, 1 / frame_rate(scene)
    last = max(frame + max(thing.thurible_hold for thing in things) for frame, things in keyframes.items())
    if last > scene.frame_end:
        raise Refused(f"A keyframe is held until frame {last}; hold it for less, or let the scene end at frame {last}")
    if settings.release and last == scene.frame_end:
        raise Refused(f"The smoke is let go after frame {last}, which is the scene's last; let the scene end later")
    everything = [settings.domain, *sources, *solids]
    everything += [thing for things in (*keyframes.values(), *emitting.values()) for thing in things]
    current = scene.frame_current
    with shown([thing for thing in everything if thing is not None]):
        try:
            scene.frame_set(scene.frame_start)
            low, longest, cells = grid(settings)
            folder.mkdir(parents=True, exist_ok=True)
            if sources:
                write_obj(folder / "source.obj", sources, low)
            if solids:
                write_obj(folder / "solids.obj", solids, low)
            for until, things in emitting.items():
                write_obj(folder / f"emitter_{until:04}.obj", things, low)
            for frame, things in keyframes.items():
                scene.frame_set(frame)
                write_obj(folder / f"keyframe_{frame:04}.obj", things, low)
        finally:
            scene.frame_set(current)
    boundary = '["wall", "wall", ["wall", "open"]]' if settings.open_top else '"wall"'
    lines = [
        "# Written by the Blender extension of thurible.",
        f"[grid]\ncells = {cells}\nlength = {longest!r}\nboundary = {boundary}",
        f"[time]\nsteps = {steps}\ndt = {dt!r}",
    ]
    if sources:
        lines.append(f"[source]\n{shape('source.obj')}")
    for until in emitting:
        lines.append(f"[[emitter]]\nto = {until - scene.frame_start}\nrate = {settings.rate!r}\n{shape(f'emitter_{until:04}.obj')}")
    if solids:
        lines.append(f"[[obstacle]]\n{shape('solids.obj')}")
    for frame, things in keyframes.items():
        hold = max(thing.thurible_hold for thing in things)
        held = f"hold = {hold}\n" if hold else ""
        lines.append(f"[[keyframe]]\nstep = {frame - scene.frame_start}\n{held}{shape(f'keyframe_{frame:04}.obj')}")
    if settings.release:
        lines.append(f"[[release]]\nfrom = {last - scene.frame_start}")
    lines.append(f"[control]\nforce_weight = {weight(settings, longest, dt)!r}")
    if settings.buoyancy:
        lines.append(f"[flow]\nbuoyancy = {settings.buoyancy * longest / dt**2!r}")
    lines.append(f"[method]\niterations = {settings.iterations}\n[output]\nframes = false\n")
    place = {"low": low, "frame_start": scene.frame_start}
    (folder / PLACE).write_text(json.dumps(place), encoding="utf-8")
    path = folder / SCENE
    path.write_text("\n\n".join(lines), encoding="utf-8")
    return path


def by_hand(folder):
    """The scene that is there, as it is."""
    path = pathlib.Path(folder) / SCENE
    for name in (SCENE, PLACE):
        if not (path.parent / name).is_file():
            raise Refused(f"There is no {name} in {path.parent}; press Memory without By Hand first, which writes it")
    return path
