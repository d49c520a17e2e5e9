//! The kernels by name, and the numbers that each dispatch is given.

use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType,
    ComputePipeline, ComputePipelineDescriptor, Device, PipelineCompilationOptions, PipelineLayoutDescriptor,
    ShaderModuleDescriptor, ShaderSource, ShaderStages,
};

/// Elements that a group of a kernel takes.
pub const GROUP: u64 = 256;

/// A file of kernels: its name, its text, and the buffers that it binds.
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
        buffers: 3,
    },
    File {
        name: "force",
        text: include_str!("kernels/force.wgsl"),
        buffers: 4,
    },
    File {
        name: "spectral",
        text: include_str!("kernels/spectral.wgsl"),
        buffers: 3,
    },
    File {
        name: "transport",
        text: include_str!("kernels/transport.wgsl"),
        buffers: 6,
    },
];

/// A kernel: an entry of one of the files in `kernels`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    Add,
    Multiply,
    DotAll,
    Largest,
    Force,
    ForceBack,
    Price,
    Divergence,
    SubtractGradient,
    Transform,
    Invert,
    FilterAll,
    Carry,
    CarryBack,
    Courant,
}

impl Kernel {
    const ALL: [Self; 15] = [
        Self::Add,
        Self::Multiply,
        Self::DotAll,
        Self::Largest,
        Self::Force,
        Self::ForceBack,
        Self::Price,
        Self::Divergence,
        Self::SubtractGradient,
        Self::Transform,
        Self::Invert,
        Self::FilterAll,
        Self::Carry,
        Self::CarryBack,
        Self::Courant,
    ];

    /// Its file, and the name of its entry there.
    const fn place(self) -> (usize, &'static str) {
        match self {
            Self::Add => (0, "add"),
            Self::Multiply => (0, "multiply"),
            Self::DotAll => (0, "dot_all"),
            Self::Largest => (0, "largest"),
            Self::Force => (1, "force"),
            Self::ForceBack => (1, "force_back"),
            Self::Price => (1, "price"),
            Self::Divergence => (2, "divergence"),
            Self::SubtractGradient => (2, "subtract_gradient"),
            Self::Transform => (2, "transform"),
            Self::Invert => (2, "invert"),
            Self::FilterAll => (2, "filter_all"),
            Self::Carry => (3, "carry"),
            Self::CarryBack => (3, "carry_back"),
            Self::Courant => (3, "courant"),
        }
    }

    /// Buffers that it binds.
    pub const fn buffers(self) -> usize {
        FILES[self.place().0].buffers as usize
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

/// All kernels, compiled.
#[derive(Debug)]
pub struct Kernels {
    pipelines: Vec<ComputePipeline>,
    layouts: Vec<BindGroupLayout>,
}

impl Kernels {
    /// Compiles them for a device.
    pub fn new(device: &Device) -> Self {
        let layouts = FILES.each_ref().map(|file| layout(device, file.buffers));
        let modules = FILES.each_ref().map(|file| {
            device.create_shader_module(ShaderModuleDescriptor {
                label: Some(file.name),
                source: ShaderSource::Wgsl(format!("{COMMON}\n{}", file.text).into()),
            })
        });
        let pipelines = Kernel::ALL.map(|kernel| {
            let (file, entry) = kernel.place();
            let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
                label: Some(entry),
                bind_group_layouts: &[Some(&layouts[file])],
                immediate_size: NUMBERS as u32,
            });
            device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&layout),
                module: &modules[file],
                entry_point: Some(entry),
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            })
        });
        Self {
            pipelines: pipelines.into(),
            layouts: layouts.into(),
        }
    }

    /// One of them.
    pub fn pipeline(&self, kernel: Kernel) -> &ComputePipeline {
        &self.pipelines[kernel as usize]
    }

    /// What its buffers are bound by.
    pub fn layout(&self, kernel: Kernel) -> &BindGroupLayout {
        &self.layouts[kernel.place().0]
    }
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
