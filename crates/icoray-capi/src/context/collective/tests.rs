//! Two ranks, which are threads of this process, and failures on one of them.

use super::*;
use crate::boundary::tests::{config, loud, message};
use crate::frames::{icoray_execute, icoray_wait, icoray_wants};
use crate::handle::{CallKind, icoray_ctx, with};
use crate::inputs::{icoray_scene_load, icoray_scene_text};
use icoray_core::ranks::on_local_nodes;
use icoray_status::*;
use std::ffi::{CStr, CString};
use std::ptr;

const SCENE: &CStr = c"field = 'f'
every = 2
camera = { lon = 0, lat = 0, distance = 3 }
transfer = { map = 'viridis', range = [0, 1], opacity = [[0, 0.5], [1, 0.5]] }";

/// A context of one rank, and which it is.
struct Model {
    rank: usize,
    ctx: Box<icoray_ctx>,
}

impl Model {
    fn wants(&self, step: i64) -> (icoray_status, i32) {
        let mut wants = 7;
        // SAFETY: an open context and a live number.
        let status = unsafe { icoray_wants(&raw const *self.ctx as *mut _, step, 0.0, &mut wants) };
        (status, wants)
    }

    fn execute(&self, step: i64) -> icoray_status {
        // SAFETY: an open context.
        unsafe { icoray_execute(&raw const *self.ctx as *mut _, step, 0.0, ptr::null()) }
    }

    /// Takes the scene from a text or, where that is `None`, from NULL.
    fn set_scene(&self, text: Option<&CStr>) -> icoray_status {
        let text = text.map_or(ptr::null(), CStr::as_ptr);
        // SAFETY: an open context, and NULL or a string.
        unsafe { icoray_scene_text(&raw const *self.ctx as *mut _, text) }
    }

    fn load(&self, path: &CStr) -> icoray_status {
        // SAFETY: an open context and a string.
        unsafe { icoray_scene_load(&raw const *self.ctx as *mut _, path.as_ptr()) }
    }

    fn wait(&self) -> icoray_status {
        // SAFETY: an open context.
        unsafe { icoray_wait(&raw const *self.ctx as *mut _) }
    }

    fn message(&self) -> String {
        message(&raw const *self.ctx)
    }
}

/// Runs a model on two ranks.
fn on_two(model: impl Fn(&Model) + Sync) {
    loud();
    on_local_nodes(&[0; 2], |team| {
        let ranks = Ranks::new(team);
        let mut context = Context::new(&config(), "", &ranks, 1).unwrap();
        let rank = ranks.rank();
        context.join(ranks).unwrap();
        model(&Model { rank, ctx: Box::new(icoray_ctx::new(context)) });
    });
}

#[test]
fn all_have_the_scene_of_rank_0_or_none() {
    let file = std::env::temp_dir().join(format!("icoray-scene-{}.toml", std::process::id()));
    std::fs::write(&file, SCENE.to_bytes()).unwrap();
    let path = CString::new(file.to_str().unwrap()).unwrap();
    on_two(|model| {
        let of = |root: &'static CStr, other| if model.rank == 0 { root } else { other };
        assert_eq!(model.wants(2), (ICORAY_OK, 0));
        assert_eq!(model.load(if model.rank == 0 { c"nowhere" } else { &path }), ICORAY_ERR_IO);
        assert!(model.message().starts_with("rank 0: nowhere: cannot read the scene"), "{}", model.message());
        assert_eq!(model.set_scene(Some(of(c"field = 1", SCENE))), ICORAY_ERR_SCENE);
        for odd in [0, 1] {
            assert_eq!(model.set_scene((model.rank != odd).then_some(SCENE)), ICORAY_ERR_NULL);
            assert_eq!(model.message(), format!("rank {odd}: toml is NULL"));
        }
        assert_eq!(model.wants(2), (ICORAY_OK, 0));

        assert_eq!(model.load(if model.rank == 0 { &path } else { c"nowhere" }), ICORAY_OK);
        assert_eq!([model.wants(2), model.wants(3)], [(ICORAY_OK, 1), (ICORAY_OK, 0)]);
        assert_eq!(model.set_scene(Some(of(c"field = 1", c""))), ICORAY_ERR_SCENE);
        assert_eq!(model.wants(2), (ICORAY_OK, 1), "that of before stays");
        assert_eq!(model.set_scene(Some(of(c"", SCENE))), ICORAY_OK);
        assert_eq!(model.wants(2), (ICORAY_OK, 0), "nothing is to be drawn");
    });
    std::fs::remove_file(file).unwrap();
}

#[test]
fn a_bug_on_one_rank_changes_no_answer_before_an_agreement() {
    for odd in [0, 1] {
        on_two(|model| {
            assert_eq!(model.set_scene(Some(SCENE)), ICORAY_OK);
            if model.rank == odd {
                // SAFETY: an open context.
                let status = unsafe { with(&raw const *model.ctx, CallKind::Local, |_| panic!("out of bounds")) };
                assert_eq!(status, ICORAY_ERR_INTERNAL);
            }
            assert_eq!(model.wants(2), (ICORAY_OK, 1));
            assert_eq!(model.execute(2), ICORAY_ERR_INTERNAL);
            assert!(model.message().contains("out of bounds"), "{}", model.message());
            assert_eq!(model.wants(2), (ICORAY_ERR_INTERNAL, 0));
            assert_eq!(model.set_scene(Some(SCENE)), ICORAY_ERR_INTERNAL);
            assert_eq!(model.wait(), ICORAY_ERR_INTERNAL);
        });
    }
}
