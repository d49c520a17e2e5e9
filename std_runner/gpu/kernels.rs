//! The kernels by name, and the numbers that each dispatch is given.

use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType,
    ComputePipeline, ComputePipelineDescriptor, Device, PipelineCompilationOptions, PipelineLayoutDescriptor,
    ShaderModule, ShaderModuleDescriptor, ShaderRuntimeChecks, ShaderSource, ShaderStages,
};

/// Elements that a group of a kernel takes.
pub const GROUP: u64 = 256;

/// A file of kernels: its name, its text, and the buffers that it binds, of which the last is the table of solid cells.
struct File {
    name: &'static str,
    text: &'static str,
    buffers: u32,
}

const COMMON: &str = include_str!("kernels/common.wgsl");
const FILES: [File; 4] = [
    File {
        name: "elements",
        text: include_str!("kernels/elements.wgsl"),
        buffers: 4,
    },
    File {
        name: "force",
        text: include_str!("kernels/force.wgsl"),
        buffers: 5,
    },
    File {
        name: "spectral",
        text: include_str!("kernels/spectral.wgsl"),
        buffers: 4,
    },
    File {
        name: "transport",
        text: include_str!("kernels/transport.wgsl"),
        buffers: 7,
    },
];

/// Defines the kernels: each with the number of its file, and the name of its entry there.
macro_rules! kernels {
    ($($kernel:ident: $file:literal, $entry:literal;)+) => {
        /// A kernel: an entry of one of the files in `kernels`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Kernel {
            $($kernel,)+
        }

        /// File and entry of each, at its number.
        const PLACES: &[(usize, &str)] = &[$(($file, $entry),)+];
    };
}

kernels! {
    Add: 0, "add";
    AddEach: 0, "add_each";
    Multiply: 0, "multiply";
    Fill: 0, "fill";
    Forget: 0, "forget";
    DotAll: 0, "dot_all";
    Largest: 0, "largest";
    Force: 1, "force";
    ForceBack: 1, "force_back";
    Price: 1, "price";
    Lift: 1, "lift";
    LiftBack: 1, "lift_back";
    Push: 1, "push";
    Weigh: 1, "weigh";
    Close: 1, "close";
    Divergence: 2, "divergence";
    SubtractGradient: 2, "subtract_gradient";
    Transform: 2, "transform";
    Invert: 2, "invert";
    FilterAll: 2, "filter_all";
    Gaussian: 2, "gaussian";
    ThroughOpen: 2, "through_open";
    LeaveOut: 2, "leave_out";
    Carry: 3, "carry";
    CarryBack: 3, "carry_back";
    Courant: 3, "courant";
}

impl Kernel {
    const fn file(self) -> usize {
        PLACES[self as usize].0
    }

    /// Buffers that it writes, the first ones.
    pub const fn writes(self) -> usize {
        if matches!(self, Self::CarryBack) { 3 } else { 1 }
    }

    /// Buffers that it binds.
    pub const fn buffers(self) -> usize {
        FILES[self.file()].buffers as usize
    }
}

/// What a kernel does, by the bits that the files in `kernels` call flags.
pub const FLAGS: u32 = 8;

/// The numbers of a dispatch: `Numbers` in `kernels/common.wgsl`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Numbers {
    pub n: [u32; 3],
    pub apart: u32,
    pub inverse: [f32; 3],
    pub a: f32,
    pub b: f32,
    pub c: f32,
    pub count: u32,
    pub flags: u32,
    pub axis: u32,
    pub first: u32,
    pub second: u32,
    pub third: u32,
}

/// Bytes of [`Numbers`].
pub const NUMBERS: usize = 64;

impl Numbers {
    /// As they go to the device.
    pub fn bytes(&self) -> [u8; NUMBERS] {
        let [x, y, z] = self.n;
        let [ix, iy, iz] = self.inverse.map(f32::to_bits);
        let words = [
            x,
            y,
            z,
            self.apart,
            ix,
            iy,
            iz,
            self.a.to_bits(),
            self.b.to_bits(),
            self.c.to_bits(),
            self.count,
            self.flags,
            self.axis,
            self.first,
            self.second,
            self.third,
        ];
        let mut bytes = [0; NUMBERS];
        for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

/// All kernels, compiled for boxes of so many axes.
#[derive(Debug)]
pub struct Kernels {
    dims: usize,
    pipelines: Vec<ComputePipeline>,
    layouts: Vec<BindGroupLayout>,
}

impl Kernels {
    /// None of them yet.
    pub fn new(device: &Device) -> Self {
        Self {
            dims: 0,
            pipelines: Vec::new(),
            layouts: FILES.iter().map(|file| layout(device, file.buffers)).collect(),
        }
    }

    /// Compiles them for boxes of so many axes, unless they are.
    pub fn compile(&mut self, device: &Device, dims: usize) {
        if self.dims == dims {
            return;
        }
        let modules = FILES.each_ref().map(|file| {
            let text = format!("const DIMS: u32 = {dims}u;\n{COMMON}\n{}", file.text);
            module(device, file.name, text)
        });
        let pipelines = PLACES.iter().map(|&(file, entry)| {
            let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
                label: Some(entry),
                bind_group_layouts: &[Some(&self.layouts[file])],
                immediate_size: NUMBERS as u32,
            });
            device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&layout),
                module: &modules[file],
                entry_point: Some(entry),
                compilation_options: PipelineCompilationOptions {
                    // They write what they read of it.
                    zero_initialize_workgroup_memory: false,
                    ..PipelineCompilationOptions::default()
                },
                cache: None,
            })
        });
        (self.pipelines, self.dims) = (pipelines.collect(), dims);
    }

    /// One of them.
    pub fn pipeline(&self, kernel: Kernel) -> &ComputePipeline {
        &self.pipelines[kernel as usize]
    }

    /// What its buffers are bound by.
    pub fn layout(&self, kernel: Kernel) -> &BindGroupLayout {
        &self.layouts[kernel.file()]
    }
}

/// A file of kernels, with the bounds of buffers checked, and without counters in its loops, which would not be compiled to straight code.
#[allow(unsafe_code, reason = "wgpu has no safe way to leave counters out")]
fn module(device: &Device, name: &str, text: String) -> ShaderModule {
    let described = ShaderModuleDescriptor {
        label: Some(name),
        source: ShaderSource::Wgsl(text.into()),
    };
    let checks = ShaderRuntimeChecks {
        force_loop_bounding: false,
        int_div_checks: false,
        ..ShaderRuntimeChecks::checked()
    };
    // SAFETY: the texts are those of FILES alone. Every loop there counts up to a number of terms, elements or axes, or halves a number down to
    // 0, so none is endless. Divisors are 1, 2, 16, 64, the axes, and numbers of cells, groups and tiles, of which there is 1 at least, and no remainder is of -1.
    unsafe { device.create_shader_module_trusted(described, checks) }
}

fn layout(device: &Device, buffers: u32) -> BindGroupLayout {
    let entries: Vec<_> = (0..buffers)
        .map(|binding| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty: BindingType::Buffer {
                ty: BufferBindingType::Storage { read_only: false },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}
