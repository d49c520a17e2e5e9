# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume sequence of an export, with a material, in its place and at its time."""

import json
import pathlib

import bpy

NAME = "Thurible smoke"


def material(density):
    """A material of smoke that is opaque where it is thick."""
    made = bpy.data.materials.get(NAME) or bpy.data.materials.new(NAME)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeVolumePrincipled")
    end = nodes.new("ShaderNodeOutputMaterial")
    end.location = (300, 0)
    shader.inputs["Density"].default_value = density
    shader.inputs["Color"].default_value = (0.8, 0.8, 0.8, 1)
    made.node_tree.links.new(shader.outputs["Volume"], end.inputs["Volume"])
    return made


def load(scene, export, low):
    """Puts the sequence in the folder `export` into `scene`, the corner of its box at `low`; the answer is the object."""
    export = pathlib.Path(export)
    facts = json.loads((export / "export.json").read_text(encoding="utf-8"))
    first, last = facts["frames"]
    files = [export / "vdb" / f"smoke.{frame:04}.vdb" for frame in range(first, last + 1)]
    data = bpy.data.volumes.new(NAME)
    data.filepath = str(files[0])
    data.is_sequence = True
    data.frame_duration = len(files)
    data.frame_start = scene.frame_start
    data.frame_offset = first - 1
    data.sequence_mode = "CLIP"
    data.velocity_unit = "SECOND"
    data.materials.append(material(facts["shader_density"]))
    old = bpy.data.objects.get(NAME)
    if old is not None and old.type == "VOLUME":
        old.data, thing = data, old
    else:
        thing = bpy.data.objects.new(NAME, data)
        scene.collection.objects.link(thing)
    thing.location = low
    return thing
