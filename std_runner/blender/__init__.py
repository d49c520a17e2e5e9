# SPDX-License-Identifier: GPL-3.0-or-later
"""Thurible in Blender: shapes become a scene, the scene smoke that passes through them, and that a volume sequence."""

import pathlib
import tempfile
import textwrap
import traceback

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import job, scene_file, volume

# How often a running job is looked at, in seconds.
LOOK = 0.25
# About how many pixels a letter of a panel takes.
LETTER = 7
# What a file, a program or a user's objects may be the reason for: said in the panel.
FAILURES = (scene_file.Refused, OSError, ValueError, KeyError)
running = None
# Folders of scenes of a file that was never saved.
temporary = {}


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(name="Program", description="The program thurible; empty: the one on the PATH", subtype="FILE_PATH")

    def draw(self, _context):
        self.layout.prop(self, "program")


class Settings(bpy.types.PropertyGroup):
    domain: PointerProperty(type=bpy.types.Object, name="Domain", description="Its bounding box is where the smoke may be")
    source: PointerProperty(type=bpy.types.Collection, name="Source", description="The smoke at the first frame")
    emitters: PointerProperty(
        type=bpy.types.Collection, name="Emitters", description="Objects that make smoke, each up to the frame that it names"
    )
    keyframes: PointerProperty(
        type=bpy.types.Collection, name="Keyframes", description="Shapes that the smoke takes, each at the frame that it names"
    )
    solids: PointerProperty(type=bpy.types.Collection, name="Solids", description="What nothing flows through")
    resolution: IntProperty(name="Resolution", description="Cells along the longest side of the domain", default=48, min=4, max=1024)
    iterations: IntProperty(name="Iterations", description="At most", default=60, min=1, max=10000)
    force_weight: FloatProperty(
        name="Force weight", description="Small: keyframes are met closely; large: the force stays small", default=100.0, min=1e-6
    )
    buoyancy: FloatProperty(name="Buoyancy", description="How smoke rises, in boxes a frame squared", default=0.0, precision=5)
    rate: FloatProperty(name="Rate", description="The density that emitters add in a frame", default=0.1, min=1e-6)
    open_top: BoolProperty(name="Open top", description="Smoke and air may leave at the top of the domain", default=False)
    release: BoolProperty(name="Let go", description="No force acts after the last keyframe: the smoke goes on by itself", default=False)
    threads: IntProperty(name="Threads", description="0: as many as the machine offers", default=0, min=0, max=4096)
    memory_limit: FloatProperty(name="Memory limit", description="In GiB; 0: what the machine has", default=0.0, min=0.0)
    folder: StringProperty(
        name="Folder", description="Where scene and result go; empty: beside the file, or a temporary one until that is saved", subtype="DIR_PATH"
    )
    by_hand: BoolProperty(name="By hand", description="Solve the folder's scene.toml and its meshes as they are, instead of writing them anew", default=False)
    smoke: PointerProperty(type=bpy.types.Object, name="Smoke", description="The volume that the result is shown by")
    memory: StringProperty(name="Memory", description="What a solve takes")
    progress: FloatProperty(name="Progress", min=0, max=1, subtype="FACTOR")
    said: StringProperty()
    # Not kept: what a file or a step of undo brings back says nothing of a job.
    busy: BoolProperty(get=lambda _settings: running is not None)


def program_path(context):
    addon = context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.program) if addon and addon.preferences.program else ""


def folder_of(scene, make=True):
    """The folder of a scene: the one that is chosen, or one of its own beside the file; of a file that was never saved a temporary one, or None."""
    settings = scene.thurible
    if settings.folder:
        return pathlib.Path(bpy.path.abspath(settings.folder))
    if bpy.data.filepath:
        file = pathlib.Path(bpy.data.filepath)
        return file.with_name(f"{file.stem}_thurible") / bpy.path.clean_name(scene.name)
    if make and scene.name not in temporary:
        temporary[scene.name] = tempfile.mkdtemp(prefix="thurible_")
    return pathlib.Path(temporary[scene.name]) if scene.name in temporary else None


def resources(settings):
    """What the program may take, as its options."""
    taken = ["--threads", str(settings.threads)] if settings.threads else []
    limit = int(settings.memory_limit * 2**30)
    return taken + (["--memory-limit", str(limit)] if limit else [])


def in_words(count):
    for unit in ("bytes", "KiB", "MiB", "GiB"):
        if count < 1024:
            return f"{count:.4g} {unit}"
        count /= 1024
    return f"{count:.4g} TiB"


def say(settings, text):
    """Shows a text in the panel, and prints it, since a panel is narrow."""
    settings.said = text
    print(f"thurible: {text}")


def planned(context):
    """Writes the scene, unless it is written by hand, and says what it takes; the path of its file."""
    settings, folder = context.scene.thurible, folder_of(context.scene)
    written = scene_file.by_hand(folder) if settings.by_hand else scene_file.write(context, folder)
    settings.memory = in_words(job.memory(program_path(context), written, resources(settings)))
    return written


def begin(context, goes_on):
    """Begins a job, of a scene that is written now or of a solve that is there."""
    global running
    scene, settings = context.scene, context.scene.thurible
    written = folder_of(scene) / scene_file.SCENE if goes_on else planned(context)
    running = job.Job(program_path(context), written, resources(settings), goes_on, scene_file.frame_rate(scene), settings.iterations)
    running.scene = scene.name
    settings.progress, settings.said = 0.0, "going on" if goes_on else f"solving in {settings.memory}"
    bpy.app.timers.register(look, first_interval=LOOK)


class Deed(bpy.types.Operator):
    """A button that waits for a job, and says why it cannot do what it should."""

    @classmethod
    def poll(cls, context):
        return not context.scene.thurible.busy

    def execute(self, context):
        try:
            self.do(context)
        except FAILURES as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}


class Plan(Deed):
    bl_idname = "thurible.plan"
    bl_label = "Memory"
    bl_description = "Write the scene and say how much memory a solve takes"

    def do(self, context):
        planned(context)
        self.report({"INFO"}, f"A solve takes {context.scene.thurible.memory}")


class Solve(Deed):
    bl_idname = "thurible.solve"
    bl_label = "Solve"
    bl_description = "Find the smoke that passes through the keyframes, and bring it in as a volume"

    def do(self, context):
        begin(context, False)


class Resume(Deed):
    bl_idname = "thurible.resume"
    bl_label = "Go on"
    bl_description = "Go on with the solve that was not finished, from its last state"

    def do(self, context):
        begin(context, True)


class Load(Deed):
    bl_idname = "thurible.load"
    bl_label = "Load volumes"
    bl_description = "Bring in the last volumes of the folder again"

    def do(self, context):
        volume.load(context.scene, volume.newest(folder_of(context.scene)))


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
    say(scene.thurible, said)
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
        say(settings, ended.failure)
        return None
    volume.load(scene, ended.export)
    volume.remove_others(ended.export)
    notes = ["cancelled: the smoke so far" if ended.cancelled else "done", *ended.notes]
    if not settings.folder and not bpy.data.filepath:
        notes.append("The volumes are in a temporary folder: save the file and solve again, or choose a folder, to keep them.")
    say(settings, "\n".join(notes))
    return None


def drop():
    """Stops the job, whose scene goes or that cannot be followed any more."""
    global running
    ended, running = running, None
    if ended is not None:
        ended.cancel()


@persistent
def leave(*_file):
    """Another file is opened."""
    drop()
    temporary.clear()


class Panel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_thurible"
    bl_label = "Thurible"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Thurible"

    def draw(self, context):
        layout, settings = self.layout, context.scene.thurible
        layout.use_property_split = True
        for name in ("domain", "source", "emitters", "keyframes", "solids"):
            layout.prop(settings, name)
        thing = context.object
        if thing is not None and settings.keyframes and thing.name in settings.keyframes.all_objects:
            layout.prop(thing, "thurible_frame")
            layout.prop(thing, "thurible_hold")
        if thing is not None and settings.emitters and thing.name in settings.emitters.all_objects:
            layout.prop(thing, "thurible_until")
        for name in ("resolution", "iterations", "force_weight", "buoyancy", "rate", "open_top", "release", "threads", "memory_limit", "folder", "by_hand"):
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
            folder = folder_of(context.scene, make=False)
            if folder is not None and job.is_unfinished(folder):
                layout.operator(Resume.bl_idname)
            self.write(context, settings.said)
            layout.operator(Load.bl_idname)

    def write(self, context, text):
        """A text, in as many lines as the panel needs for it."""
        width = context.region.width if context.region else 300
        letters = max(20, int(width / (LETTER * context.preferences.system.ui_scale)))
        column = self.layout.column(align=True)
        for paragraph in text.splitlines():
            for line in textwrap.wrap(paragraph, letters):
                column.label(text=line)


classes = (Preferences, Settings, Plan, Solve, Resume, Cancel, Load, Panel)


def register():
    for kind in classes:
        bpy.utils.register_class(kind)
    bpy.types.Scene.thurible = PointerProperty(type=Settings)
    bpy.types.Object.thurible_frame = IntProperty(
        name="Frame", description="When the smoke takes this shape; 0: at the last frame", default=0, min=0
    )
    bpy.types.Object.thurible_hold = IntProperty(name="Hold", description="For how many frames more it keeps this shape", default=0, min=0)
    bpy.types.Object.thurible_until = IntProperty(
        name="Until", description="The frame that it makes smoke up to; 0: to the last one", default=0, min=0
    )
    bpy.app.handlers.load_pre.append(leave)


def unregister():
    drop()
    bpy.app.handlers.load_pre.remove(leave)
    if bpy.app.timers.is_registered(look):
        bpy.app.timers.unregister(look)
    for name in ("thurible_frame", "thurible_hold", "thurible_until"):
        delattr(bpy.types.Object, name)
    del bpy.types.Scene.thurible
    for kind in reversed(classes):
        bpy.utils.unregister_class(kind)
