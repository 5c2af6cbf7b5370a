//! A picture of a few hundred pixels, its tiles, and the results of merging and resuming from a
//! file of them.

use phalanx::frame::{Accel, Aovs, Control, Engine, Settings};
use phalanx::jobs::spec::AsText;
use phalanx::jobs::{
    ExposureSpec, PictureSpec, PlannedCamera, RenderKey, RenderPlan, SequencePlan, ShardBy,
    TileFile, TileOutputs, merge_bands, render_bands, render_to_file,
};
use phalanx::render::Film;
use phalanx::scene::{CameraKey, CameraPath, Scene};
use std::path::Path;

const SCENE: &str =
    "size 40 24\ncamera 0 0 4 0 0 0 0 1 0 45\npoint 4 4 4 1 1 1\ndiffuse 1 0.5 0\nsphere 0 0 0 1\n";

pub struct FuzzedPicture {
    scene: Scene,
    prepared: Accel,
    settings: Settings,
    identity: RenderKey,
    /// The picture rendered without a file.
    pub film: Film,
}

impl FuzzedPicture {
    pub fn new() -> FuzzedPicture {
        let scene = phalanx::formats::read_test(SCENE).unwrap().scene;
        let prepared = Accel::build(&scene, Engine::Simd);
        let settings = Settings {
            tile: 8,
            ..Settings::of(&scene)
        };
        let identity = RenderKey::of(&scene, &settings);
        let mut picture = FuzzedPicture {
            scene,
            prepared,
            settings,
            identity,
            film: Film::new(0, 0, false),
        };
        picture.film = picture.rendered(&picture.settings, None).unwrap();
        picture
    }

    pub fn size(&self) -> (u32, u32) {
        (self.settings.width, self.settings.height)
    }

    fn rendered(&self, settings: &Settings, file: Option<&TileFile>) -> Option<Film> {
        let outputs = TileOutputs {
            file,
            thumbnail: None,
        };
        let mut all = None;
        let take = |film| {
            assert!(all.replace(film).is_none(), "one band is enough");
            true
        };
        let (tree, control) = (self.prepared.accel(), Control::default());
        render_bands(&self.scene, tree, settings, &control, outputs, take).unwrap();
        all
    }

    /// Resumes a render from a file of tiles, if it belongs to this picture.
    pub fn resumed(&self, path: &Path) -> Option<Film> {
        let file = TileFile::open(path, &self.identity).ok()?;
        assert!(file.pixels() <= self.settings.pixels());
        self.rendered(&self.settings, Some(&file))
    }

    /// Merges a file of tiles, if it contains the whole picture.
    pub fn merged(&self, path: &Path) -> Option<Film> {
        let file = TileFile::read(path, &self.identity).ok()?;
        merge(&self.plan(1), file)
    }

    pub fn plan(&self, shards: u32) -> RenderPlan {
        let mut spec = PictureSpec {
            scene: "a.test".to_owned(),
            ..PictureSpec::default()
        };
        spec.encoding.exposure = Some(ExposureSpec::Stops(0.5));
        spec.overrides.light = vec![AsText::parse("1,2,3").unwrap()];
        let spec = spec.resolve(&self.scene);
        RenderPlan::new(spec, self.identity.clone(), "a.png".into(), shards)
    }

    /// A plan for a few frames between two views.
    pub fn sequence_plan(&self, shards: u32, shard_by: ShardBy) -> RenderPlan {
        let mut moved = self.scene.view;
        moved.eye.x += 0.5;
        let key = |frame, view| CameraKey { frame, view };
        let keys = vec![key(0, self.scene.view), key(4, moved)];
        let path = CameraPath::Keys(keys);
        let mut plan = self.plan(shards);
        plan.sequence = Some(SequencePlan {
            frames: [0, 4],
            shard_by,
            view: self.scene.view,
            camera: PlannedCamera::new(&path, "/way".to_owned()),
        });
        plan
    }

    /// Seeds: a whole file, half of one, and one of the picture with layers.
    pub fn tile_files(&self, folder: &Path) -> Vec<Vec<u8>> {
        let layers = Settings {
            aovs: Aovs::all(),
            ..self.settings.clone()
        };
        let plan = self.plan(1);
        let all = plan.tiles();
        let half = all[..all.len() / 2].to_vec();
        let kinds = [
            (&self.settings, all.clone()),
            (&self.settings, half),
            (&layers, all),
        ];
        let file = |(settings, tiles): (&Settings, _)| {
            let path = folder.join("seed.tiles");
            let _ = std::fs::remove_file(&path);
            let file = TileFile::open(&path, &RenderKey::of(&self.scene, settings)).unwrap();
            let (tree, control) = (self.prepared.accel(), Control::default());
            render_to_file(&self.scene, tree, settings, &control, tiles, &file).unwrap();
            drop(file);
            std::fs::read(&path).unwrap()
        };
        kinds.map(file).to_vec()
    }
}

/// The picture of a plan with all tiles in one file; `None` if some are missing.
pub fn merge(plan: &RenderPlan, file: TileFile) -> Option<Film> {
    if !plan.tiles().iter().all(|tile| file.has(*tile)) {
        return None;
    }
    let window = plan.window();
    let mut all = None;
    let take = |film| {
        assert!(all.replace(film).is_none(), "one band is enough");
        true
    };
    merge_bands(
        window,
        plan.spec.pixels.aovs(),
        &[file],
        &Control::default(),
        take,
    )
    .unwrap();
    all
}
