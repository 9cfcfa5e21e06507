//! Who draws: the CPU, or a GPU where there is one that can.

use icoray::{Field, Frame, Grid, Layers, Renderer, Result, Scene};

/// What `--backend` asks for.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Backend {
    /// The CPU
    Cpu,
    /// A GPU, or what acts as one; the CPU for what that cannot, which is said
    Gpu,
    /// A GPU where there is a real one, else the CPU
    Auto,
}

/// Draws on what was asked for.
pub struct Drawer<'a> {
    renderer: &'a Renderer,
    grid: &'a Grid<'a>,
    /// Who draws, or why it is the CPU; `None` where nobody else was asked for.
    gpu: Option<std::result::Result<OnGpu<'a>, String>>,
}

impl<'a> Drawer<'a> {
    /// Opens the device that `backend` asks for.
    pub fn new(backend: Backend, renderer: &'a Renderer, grid: &'a Grid<'a>) -> Self {
        let gpu = (backend != Backend::Cpu).then(|| OnGpu::new(backend, grid));
        Drawer { renderer, grid, gpu }
    }

    /// The picture, and on what it was drawn where that was asked for.
    pub fn render(&self, scene: &Scene, layers: &Layers, field: &Field) -> Result<(Frame, Option<String>)> {
        let reason = match &self.gpu {
            None => None,
            Some(Err(reason)) => Some(reason.clone()),
            Some(Ok(gpu)) => match gpu.render(self.renderer, scene, layers, field)? {
                Ok(frame) => return Ok((frame, Some(gpu.name()))),
                Err(reason) => Some(reason),
            },
        };
        let frame = self.renderer.render(scene, self.grid, layers, field)?;
        Ok((frame, reason.map(|reason| format!("the CPU: {reason}"))))
    }
}

#[cfg(feature = "gpu")]
use with_gpu::OnGpu;
#[cfg(not(feature = "gpu"))]
use without_gpu::OnGpu;

#[cfg(feature = "gpu")]
mod with_gpu {
    use super::*;
    use icoray_gpu::{Choice, Gpu, Mesh, Outcome};

    pub struct OnGpu<'a> {
        gpu: Gpu,
        mesh: Mesh<'a>,
    }

    impl<'a> OnGpu<'a> {
        pub fn new(backend: Backend, grid: &'a Grid<'a>) -> std::result::Result<Self, String> {
            let gpu = Gpu::new(&Choice::Any).map_err(|reason| reason.to_string())?;
            if backend == Backend::Auto && gpu.is_processor() {
                return Err(format!("{} is a processor itself", gpu.name()));
            }
            let mesh = gpu.mesh(grid).map_err(|reason| reason.to_string())?;
            Ok(OnGpu { gpu, mesh })
        }

        pub fn name(&self) -> String {
            self.gpu.name()
        }

        pub fn render(
            &self,
            renderer: &Renderer,
            scene: &Scene,
            layers: &Layers,
            field: &Field,
        ) -> Result<std::result::Result<Frame, String>> {
            Ok(match self.gpu.render(renderer, scene, &self.mesh, layers, field)? {
                Outcome::Drawn(frame) => Ok(*frame),
                Outcome::Left(reason) => Err(reason.to_string()),
            })
        }
    }
}

#[cfg(not(feature = "gpu"))]
mod without_gpu {
    use super::*;
    use std::convert::Infallible;
    use std::marker::PhantomData;

    /// None can be had.
    pub struct OnGpu<'a>(Infallible, PhantomData<&'a ()>);

    impl<'a> OnGpu<'a> {
        pub fn new(_: Backend, _: &'a Grid<'a>) -> std::result::Result<Self, String> {
            Err("this icoray was built without the feature \"gpu\"".into())
        }

        pub fn name(&self) -> String {
            match self.0 {}
        }

        pub fn render(
            &self,
            _: &Renderer,
            _: &Scene,
            _: &Layers,
            _: &Field,
        ) -> Result<std::result::Result<Frame, String>> {
            match self.0 {}
        }
    }
}
