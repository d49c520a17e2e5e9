# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume sequence of an export, with a material, in its place and at its time."""

import json
import pathlib
import shutil

import bpy

from .scene_file import PLACE, Refused

NAME = "Thurible smoke"
# Folders of volumes are numbered. Blender keeps the grids of a file that it has read for as long as it runs, and would show
# those again if another solve wrote to the same place.
FOLDERS = "volumes_"
# Where a material notes the density that the last export advised, to tell it from one that was chosen by hand.
ADVISED = "thurible_density"


def numbered(folder):
    """The folders of volumes by their numbers, ascending."""
    found = {}
    for path in pathlib.Path(folder).glob(FOLDERS + "*"):
        number = path.name[len(FOLDERS) :]
        if number.isdigit() and path.is_dir():
            found[int(number)] = path
    return dict(sorted(found.items()))


def another(folder):
    """The folder that the next volumes go to."""
    return pathlib.Path(folder) / f"{FOLDERS}{max(numbered(folder), default=0) + 1:03}"


def newest(folder):
    """The last folder whose export was finished."""
    finished = [path for path in numbered(folder).values() if (path / "export.json").is_file()]
    if not finished:
        raise Refused(f"There are no volumes in {folder}; press Solve first")
    return finished[-1]


def remove_others(export):
    """Removes the folders of volumes that came before `export`. What cannot be removed, since it is being read, stays."""
    for path in numbered(export.parent).values():
        if path != export:
            shutil.rmtree(path, ignore_errors=True)


def material(density):
    """A material of smoke that is opaque where it is thick; one that is there keeps what was made of it."""
    made = bpy.data.materials.get(NAME)
    if made is None:
        made = bpy.data.materials.new(NAME)
        made.use_nodes = True
        nodes = made.node_tree.nodes
        nodes.clear()
        shader = nodes.new("ShaderNodeVolumePrincipled")
        end = nodes.new("ShaderNodeOutputMaterial")
        end.location = (300, 0)
        shader.inputs["Color"].default_value = (0.8, 0.8, 0.8, 1)
        shader.inputs["Density"].default_value = density
        made.node_tree.links.new(shader.outputs["Volume"], end.inputs["Volume"])
        made[ADVISED] = shader.inputs["Density"].default_value
        return made
    for node in made.node_tree.nodes if made.node_tree else ():
        if node.bl_idname == "ShaderNodeVolumePrincipled" and node.inputs["Density"].default_value == made.get(ADVISED):
            node.inputs["Density"].default_value = density
            made[ADVISED] = node.inputs["Density"].default_value
    return made


def relative(path):
    """A path as the file keeps it: from the file on, where that has been saved on the same drive."""
    try:
        return bpy.path.relpath(str(path)) if bpy.data.filepath else str(path)
    except ValueError:
        return str(path)


def smoke_of(scene):
    """The scene's volume object, which is made where there is none; what was chosen on one that is there stays."""
    thing = scene.thurible.smoke
    if thing is None or thing.type != "VOLUME" or thing.name not in scene.objects:
        thing = bpy.data.objects.new(NAME, bpy.data.volumes.new(NAME))
        scene.collection.objects.link(thing)
        scene.thurible.smoke = thing
        thing.data.sequence_mode = "CLIP"
        thing.data.velocity_unit = "SECOND"
    return thing


def load(scene, export):
    """Puts the sequence in the folder `export` into `scene`, where and when that was solved; the answer is the object."""
    export = pathlib.Path(export)
    facts, place = (json.loads((export / name).read_text(encoding="utf-8")) for name in ("export.json", PLACE))
    first, last = facts["frames"]
    files = [export / "vdb" / f"smoke.{frame:04}.vdb" for frame in range(first, last + 1)]
    thing = smoke_of(scene)
    data = thing.data
    data.filepath = relative(files[0])
    data.is_sequence = True
    data.frame_duration = len(files)
    data.frame_start = place["frame_start"]
    data.frame_offset = first - 1
    if not data.materials:
        data.materials.append(material(facts["shader_density"]))
    else:
        material(facts["shader_density"])
    thing.location = place["low"]
    return thing
