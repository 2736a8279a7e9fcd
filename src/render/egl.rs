//! OpenGL contexts without a display, through EGL.
#![expect(unsafe_code, reason = "EGL is a C interface")]

use std::{ffi::CString, num::NonZero};

use glutin::{
    api::egl::{context::PossiblyCurrentContext, device::Device, display::Display, surface::Surface},
    config::{ConfigSurfaceTypes, ConfigTemplateBuilder},
    context::{ContextApi, ContextAttributesBuilder, GlProfile, Version},
    display::GlDisplay,
    prelude::{NotCurrentGlContext, PossiblyCurrentGlContext},
    surface::{PbufferSurface, SurfaceAttributesBuilder},
};
use serde::{Deserialize, Serialize};

use super::RenderError;

/// Which EGL device renders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceChoice {
    /// A graphics card where one works, else software.
    #[default]
    Auto,
    /// Mesa's software rasteriser.
    Software,
    /// The device of that number, as EGL lists them.
    Index(usize),
}

/// An OpenGL 2 compatibility context with a one-pixel surface: MuJoCo draws into buffers of its own.
///
/// The context belongs to the thread that made it.
#[derive(Debug)]
pub(super) struct EglContext {
    context: PossiblyCurrentContext,
    surface: Surface<PbufferSurface>,
    display: Display,
}

impl EglContext {
    /// Opens a context on the chosen device and makes it current on this thread.
    pub(super) fn new(choice: DeviceChoice) -> Result<Self, RenderError> {
        let devices =
            Device::query_devices().map_err(|error| RenderError::NoContext { tried: error.to_string() })?;
        let mut devices: Vec<_> = devices.enumerate().collect();
        match choice {
            DeviceChoice::Auto => devices.sort_by_key(|(_, device)| is_software(device)),
            DeviceChoice::Software => devices.retain(|(_, device)| is_software(device)),
            DeviceChoice::Index(wanted) => devices.retain(|(index, _)| *index == wanted),
        }
        let mut tried = Vec::new();
        for (index, device) in &devices {
            match Self::on_device(device) {
                Ok(context) => return Ok(context),
                Err(error) => tried.push(format!("device {index}: {error}")),
            }
        }
        if tried.is_empty() {
            tried.push(format!("EGL lists no device for {choice:?}"));
        }
        Err(RenderError::NoContext { tried: tried.join("; ") })
    }

    fn on_device(device: &Device) -> glutin::error::Result<Self> {
        // SAFETY: the device was listed by EGL in this process and EGL is never unloaded.
        let display = unsafe { Display::with_device(device, None)? };
        let template = ConfigTemplateBuilder::new()
            .with_surface_type(ConfigSurfaceTypes::PBUFFER)
            .with_depth_size(24)
            .with_stencil_size(8)
            .build();
        // SAFETY: the template only names attributes that every EGL display knows.
        let config = unsafe { display.find_configs(template)?.next() };
        let config = config.ok_or(glutin::error::ErrorKind::BadConfig)?;
        let attributes = ContextAttributesBuilder::new()
            .with_profile(GlProfile::Compatibility)
            .with_context_api(ContextApi::OpenGl(Some(Version::new(2, 0))))
            .build(None);
        // SAFETY: `config` was found on this very display.
        let context = unsafe { display.create_context(&config, &attributes)? };
        let one = NonZero::<u32>::MIN;
        let attributes = SurfaceAttributesBuilder::<PbufferSurface>::new().build(one, one);
        // SAFETY: as above.
        let surface = unsafe { display.create_pbuffer_surface(&config, &attributes)? };
        Ok(Self { context: context.make_current(&surface)?, surface, display })
    }

    /// Makes the context current on this thread.
    pub(super) fn make_current(&self) -> Result<(), RenderError> {
        self.context.make_current(&self.surface).map_err(|error| RenderError::NotCurrent(error.to_string()))
    }

    /// OpenGL's own name of the renderer, such as `llvmpipe (…)`. The context must be current.
    pub(super) fn renderer_name(&self) -> String {
        type GetString = unsafe extern "C" fn(u32) -> *const std::ffi::c_char;
        const GL_RENDERER: u32 = 0x1F01;
        let Ok(symbol) = CString::new("glGetString") else { return String::new() };
        let address = self.display.get_proc_address(&symbol);
        if address.is_null() {
            return String::new();
        }
        // SAFETY: the address is that of glGetString, whose C signature is `GetString`; it returns null or a
        // zero-terminated string that lives as long as the context.
        unsafe {
            let get_string = std::mem::transmute::<*const std::ffi::c_void, GetString>(address);
            let name = get_string(GL_RENDERER);
            if name.is_null() {
                String::new()
            } else {
                std::ffi::CStr::from_ptr(name).to_string_lossy().into_owned()
            }
        }
    }
}

/// OpenGL's name of the device that `choice` leads to.
///
/// # Errors
/// When no context can be opened.
pub fn describe_device(choice: DeviceChoice) -> Result<String, RenderError> {
    Ok(EglContext::new(choice)?.renderer_name())
}

fn is_software(device: &Device) -> bool {
    device.extensions().contains("EGL_MESA_device_software")
        || (device.drm_device_node_path().is_none() && device.drm_render_device_node_path().is_none())
}
