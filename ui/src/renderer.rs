//! What the window is drawn with.

use std::{
    pin::pin,
    task::{Context, Poll, Waker},
};

use clap::ValueEnum;
use eframe::{
    Renderer,
    egui_wgpu::wgpu::{Backends, DeviceType, Instance, InstanceDescriptor},
};

/// The operator's wish.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum RendererChoice {
    /// wgpu on a graphics card, OpenGL without one (default).
    #[default]
    Auto,
    /// wgpu: Vulkan, Metal, Direct3D.
    Wgpu,
    /// OpenGL.
    Opengl,
}

impl RendererChoice {
    /// The renderer for this machine.
    pub fn renderer(self) -> Renderer {
        match self {
            Self::Wgpu => Renderer::Wgpu,
            Self::Opengl => Renderer::Glow,
            // Where every pixel is computed by the processor the work for each decides: egui's shader for wgpu also
            // holds a filter for tests behind a branch that a software rasteriser walks through for every pixel.
            Self::Auto if has_graphics_card() => Renderer::Wgpu,
            Self::Auto => Renderer::Glow,
        }
    }
}

/// Whether anything but the processor can draw.
fn has_graphics_card() -> bool {
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    let found = pin!(instance.enumerate_adapters(Backends::PRIMARY));
    // Natively the answer is there at once.
    match found.poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(adapters) => {
            adapters.iter().any(|adapter| adapter.get_info().device_type != DeviceType::Cpu)
        }
        Poll::Pending => true,
    }
}
