# SPDX-License-Identifier: GPL-3.0-or-later
"""Thurible in Blender: shapes become a scene, the scene smoke that passes through them, and that a volume sequence."""

import pathlib
import tempfile
import traceback

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import job, scene_file, volume

# How often a running job is looked at, in seconds.
LOOK = 0.25
running = None


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(name="Program", description="The program thurible; empty: the one on the PATH", subtype="FILE_PATH")

    def draw(self, _context):
        self.layout.prop(self, "program")


class Settings(bpy.types.PropertyGroup):
    domain: PointerProperty(type=bpy.types.Object, name="Domain", description="Its bounding box is where the smoke may be")
    source: PointerProperty(type=bpy.types.Collection, name="Source", description="The smoke at the first frame")
    keyframes: PointerProperty(
        type=bpy.types.Collection, name="Keyframes", description="Shapes that the smoke takes, each at the frame that it names"
    )
    solids: PointerProperty(type=bpy.types.Collection, name="Solids", description="What nothing flows through")
    resolution: IntProperty(name="Resolution", description="Cells along the longest side of the domain", default=48, min=4, max=1024)
    iterations: IntProperty(name="Iterations", description="At most", default=60, min=1, max=10000)
    force_weight: FloatProperty(
        name="Force weight", description="Small: keyframes are met closely; large: the force stays small", default=100.0, min=1e-6
    )
    buoyancy: FloatProperty(name="Buoyancy", description="How smoke rises, in boxes a frame squared", default=0.0)
    folder: StringProperty(name="Folder", description="Where scene and result go; empty: a temporary one", subtype="DIR_PATH")
    memory: StringProperty(name="Memory", description="What a solve takes")
    progress: FloatProperty(name="Progress", min=0, max=1, subtype="FACTOR")
    said: StringProperty()
    # Not kept: what a file or a step of undo brings back says nothing of a job.
    busy: BoolProperty(get=lambda _settings: running is not None)


def program_path(context):
    addon = context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.program) if addon and addon.preferences.program else ""


def working_folder(settings):
    if settings.folder:
        return pathlib.Path(bpy.path.abspath(settings.folder))
    settings.folder = tempfile.mkdtemp(prefix="thurible_")
    return pathlib.Path(settings.folder)


def in_words(count):
    for unit in ("bytes", "KiB", "MiB", "GiB"):
        if count < 1024:
            return f"{count:.4g} {unit}"
        count /= 1024
    return f"{count:.4g} TiB"


def planned(context):
    """Writes the scene and says what it takes; the path of its file."""
    settings = context.scene.thurible
    written = scene_file.write(context, working_folder(settings))
    settings.memory = in_words(job.memory(program_path(context), written))
    return written


class Plan(bpy.types.Operator):
    bl_idname = "thurible.plan"
    bl_label = "Memory"
    bl_description = "Write the scene and say how much memory a solve takes"

    def execute(self, context):
        try:
            planned(context)
        except (scene_file.Refused, OSError) as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}
        self.report({"INFO"}, f"A solve takes {context.scene.thurible.memory}")
        return {"FINISHED"}


class Solve(bpy.types.Operator):
    bl_idname = "thurible.solve"
    bl_label = "Solve"
    bl_description = "Find the smoke that passes through the keyframes, and bring it in as a volume"

    @classmethod
    def poll(cls, context):
        return not context.scene.thurible.busy

    def execute(self, context):
        global running
        settings = context.scene.thurible
        try:
            written = planned(context)
            running = job.Job(
                program_path(context), written, scene_file.frame_rate(context.scene), settings.iterations
            )
        except (scene_file.Refused, OSError) as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}
        running.scene = context.scene.name
        settings.progress, settings.said = 0.0, f"solving in {settings.memory}"
        bpy.app.timers.register(look, first_interval=LOOK)
        return {"FINISHED"}


class Cancel(bpy.types.Operator):
    bl_idname = "thurible.cancel"
    bl_label = "Cancel"
    bl_description = "Stop, and bring in what there is"

    @classmethod
    def poll(cls, context):
        return context.scene.thurible.busy

    def execute(self, _context):
        if running is not None:
            running.cancel()
        return {"FINISHED"}


class Load(bpy.types.Operator):
    bl_idname = "thurible.load"
    bl_label = "Load volumes"
    bl_description = "Bring in the volumes of the folder again"

    def execute(self, context):
        settings = context.scene.thurible
        try:
            low, _longest, _cells = scene_file.grid(settings)
            volume.load(context.scene, working_folder(settings) / "volumes", low)
        except (scene_file.Refused, OSError) as refused:
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}
        return {"FINISHED"}


def look():
    """Looks at the job; called by a timer until it is over."""
    if running is None:
        return None
    # Another scene may be shown by now.
    scene = bpy.data.scenes.get(running.scene) or bpy.context.scene
    try:
        return looked(scene)
    except (scene_file.Refused, OSError) as refused:
        said = str(refused)
    except Exception as error:
        # Blender drops a timer that fails, and the job would be there for ever.
        traceback.print_exc()
        said = f"{type(error).__name__}: {error}"
    drop()
    scene.thurible.said = said
    return None


def looked(scene):
    """Shows how far the job is, and brings in what it made; seconds to the next look, or None."""
    global running
    settings, screen = scene.thurible, bpy.context.screen
    over = running.poll()
    settings.progress, settings.said = running.progress, running.said
    for area in screen.areas if screen else ():
        area.tag_redraw()
    if not over:
        return LOOK
    ended, running = running, None
    if ended.failure:
        settings.said = ended.failure
        return None
    low, _longest, _cells = scene_file.grid(settings)
    volume.load(scene, ended.export, low)
    settings.said = "cancelled: the smoke so far" if ended.cancelled else "done"
    return None


@persistent
def drop(*_file):
    """Stops the job, whose scene goes or that cannot be followed any more."""
    global running
    ended, running = running, None
    if ended is not None:
        ended.cancel()


class Panel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_thurible"
    bl_label = "Thurible"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Thurible"

    def draw(self, context):
        layout, settings = self.layout, context.scene.thurible
        layout.use_property_split = True
        for name in ("domain", "source", "keyframes", "solids"):
            layout.prop(settings, name)
        thing = context.object
        if thing is not None and settings.keyframes and thing.name in settings.keyframes.all_objects:
            layout.prop(thing, "thurible_frame")
        for name in ("resolution", "iterations", "force_weight", "buoyancy", "folder"):
            layout.prop(settings, name)
        row = layout.row()
        row.operator(Plan.bl_idname)
        if settings.memory:
            row.label(text=settings.memory)
        if settings.busy:
            layout.progress(factor=settings.progress, text=settings.said)
            layout.operator(Cancel.bl_idname)
        else:
            layout.operator(Solve.bl_idname)
            if settings.said:
                layout.label(text=settings.said)
            layout.operator(Load.bl_idname)


classes = (Preferences, Settings, Plan, Solve, Cancel, Load, Panel)


def register():
    for kind in classes:
        bpy.utils.register_class(kind)
    bpy.types.Scene.thurible = PointerProperty(type=Settings)
    bpy.types.Object.thurible_frame = IntProperty(
        name="Frame", description="When the smoke takes this shape; 0: at the last frame", default=0, min=0
    )
    bpy.app.handlers.load_pre.append(drop)


def unregister():
    drop()
    bpy.app.handlers.load_pre.remove(drop)
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
    del bpy.types.Object.thurible_frame
    del bpy.types.Scene.thurible
    for kind in reversed(classes):
        bpy.utils.unregister_class(kind)
