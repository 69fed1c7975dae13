//! Rays asked of the device: the renderer's own traversal (`glsl/probe_trace.comp`) over a mesh.
//!
//! Comes in: triangles in scaled units, a tree, rays. Goes out: the hit of each ray, with how much work it was.

use std::path::PathBuf;

use glam::Vec3;

use crate::Result;
use crate::bvh::{Accel, BinaryBvh, Builder, Hit, Intersector, Ray, WideBvh};
use crate::gpu::shaders;
use crate::interface::*;
use crate::render::Guard;
use crate::scene::{FilmSettings, Filter, LoadReport, RenderDefaults, Scaling, Scene, Triangle};
use crate::selftest::kit::TestBench;
use crate::selftest::kit::probe::Probe;
use crate::selftest::kit::scenes::{camera, lambert};
use crate::settings::{Buffers, Settings};
use crate::statistics::Finding;
use crate::texels::triangle::area;
use crate::texels::{Texel, TexelData};

/// Rays of one dispatch: 32 bytes each in a buffer.
const BATCH: usize = 1 << 20;

/// What the device says of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// The closest hit.
    pub hit: Option<Hit>,
    /// Nodes visited.
    pub nodes: u32,
    /// Triangles tested.
    pub triangles: u32,
    /// Entries that the traversal stack had no room for.
    pub overflows: u32,
}

impl Answer {
    /// Id, key and barycentrics, as bits, to compare.
    pub fn bits(&self) -> Option<[u32; 4]> {
        self.hit.map(|hit| [hit.id, hit.key.to_bits(), hit.b1.to_bits(), hit.b2.to_bits()])
    }
}

/// A mesh on the bench: its triangles, records and tree.
pub struct Mesh {
    accel: Accel,
    data: TexelData,
    /// Place in leaf order of each triangle.
    places: Vec<u32>,
    intersector: Intersector,
}

impl Mesh {
    /// Packs triangles, whose coordinates are scaled already, with a tree over them; `emits` says which ids emit.
    pub fn new(triangles: &[Triangle], accel: Accel, emits: impl Fn(u32) -> bool) -> Result<Mesh> {
        let scene = Scene {
            name: String::new(),
            path: PathBuf::new(),
            camera: camera([0.0; 3], [0.0, 0.0, 1.0], 40.0),
            film: FilmSettings { width: 1, height: 1, filter: Filter::Box },
            render: RenderDefaults::default(),
            triangles: (0..)
                .zip(triangles)
                .map(|(id, triangle)| Triangle { material: u32::from(emits(id) && area(triangle) > 0.0), ..*triangle })
                .collect(),
            corners: Vec::new(),
            materials: vec![lambert(0.5, 0.0), lambert(0.0, 1.0)],
            sky: None,
            scaling: Scaling::NONE,
            report: LoadReport::default(),
        };
        let data = TexelData::pack(&scene, &accel, &Settings::for_scene(&scene))?;
        let mut places = vec![NO_INDEX; triangles.len()];
        for (place, &id) in (0..).zip(accel.order(triangles.len()).iter()) {
            places[id as usize] = place;
        }
        Ok(Mesh { accel, data, places, intersector: Intersector::Watertight })
    }

    /// With the default tree, and no triangle that emits.
    pub fn wide(triangles: &[Triangle]) -> Result<Mesh> {
        Mesh::new(triangles, WideBvh::build(triangles, Builder::Sah).into(), |_| false)
    }

    /// The same mesh under another triangle test.
    pub fn with_intersector(self, intersector: Intersector) -> Mesh {
        Mesh { intersector, ..self }
    }

    /// The tree.
    pub fn accel(&self) -> &Accel {
        &self.accel
    }

    /// The records, to be changed before rays are traced.
    pub fn data_mut(&mut self) -> &mut TexelData {
        &mut self.data
    }

    /// The closest hit of each ray; a ray's `skip` is an id.
    pub fn trace(&self, bench: &TestBench, rays: &[Ray]) -> Result<Vec<Answer>> {
        let mut answers = Vec::with_capacity(rays.len());
        for batch in rays.chunks(BATCH) {
            answers.extend(self.trace_batch(bench, batch)?);
        }
        Ok(answers)
    }

    /// Rays that leave the mesh's own triangles: where they start and what they meet.
    pub fn leave(&self, bench: &TestBench, departures: &[Departure], kind: Leaving) -> Result<Vec<Arrival>> {
        let place = |id: u32| self.places.get(id as usize).copied().unwrap_or(NO_INDEX);
        let mut order = vec![NO_INDEX; self.places.len()];
        (0..).zip(&self.places).for_each(|(id, &place)| order[place as usize] = id);
        let mut arrivals = Vec::with_capacity(departures.len());
        for batch in departures.chunks(BATCH) {
            let input: Vec<Texel> = batch
                .iter()
                .flat_map(|departure| {
                    let [wo, d] = [departure.wo, departure.d].map(|v| v.to_array().map(f32::to_bits));
                    let [b1, b2] = departure.barycentrics.map(f32::to_bits);
                    [
                        [place(departure.id), b1, b2, 0],
                        [wo[0], wo[1], wo[2], place(departure.light)],
                        [d[0], d[1], d[2], 0],
                    ]
                })
                .collect();
            let answers = bench.probe(Probe {
                module: shaders::PROBE_ORIGINS,
                data: &self.data,
                accel: &self.accel,
                buffers: Buffers::Texel,
                specialization: Vec::new(),
                function: kind as u32,
                first_sample: 0,
                calls: batch.len() as u32,
                input: &input,
                output_texels: 2,
                without_guard: None,
            })?;
            arrivals.extend(answers.as_chunks::<2>().0.iter().map(|&[[x, y, z, triangle], [px, py, pz, key]]| {
                Arrival {
                    origin: Vec3::from_array([x, y, z].map(f32::from_bits)),
                    point: Vec3::from_array([px, py, pz].map(f32::from_bits)),
                    hit: order.get(triangle as usize).copied(),
                    key: f32::from_bits(key),
                }
            }));
        }
        Ok(arrivals)
    }

    fn trace_batch(&self, bench: &TestBench, rays: &[Ray]) -> Result<Vec<Answer>> {
        let skipped = |id: u32| self.places.get(id as usize).copied().unwrap_or(NO_INDEX);
        let input: Vec<Texel> = rays
            .iter()
            .flat_map(|ray| {
                let [o, d] = [ray.origin, ray.direction].map(|v| v.to_array().map(f32::to_bits));
                [[o[0], o[1], o[2], skipped(ray.skip)], [d[0], d[1], d[2], 0]]
            })
            .collect();
        let test = match self.intersector {
            Intersector::Watertight => INTERSECTOR_WATERTIGHT,
            Intersector::MollerTrumbore => INTERSECTOR_MOLLER_TRUMBORE,
        };
        let mut specialization = vec![(SPEC_INTERSECTOR, test)];
        if !bench.has(Guard::StackDepth) {
            specialization.push((SPEC_STACK_ENTRIES, 2));
        }
        let answers = bench.probe(Probe {
            module: if bench.has(Guard::UnfusedEdges) { shaders::PROBE_TRACE } else { shaders::PROBE_TRACE_FUSED },
            data: &self.data,
            accel: &self.accel,
            buffers: Buffers::Texel,
            specialization,
            function: 0,
            first_sample: 0,
            calls: rays.len() as u32,
            input: &input,
            output_texels: 2,
            without_guard: None,
        })?;
        let answer = |&[[key, id, triangle, overflows], [b1, b2, nodes, triangles]]: &[Texel; 2]| {
            let [key, b1, b2] = [key, b1, b2].map(f32::from_bits);
            Answer { hit: (triangle != NO_INDEX).then_some(Hit { id, key, b1, b2 }), nodes, triangles, overflows }
        };
        Ok(answers.as_chunks::<2>().0.iter().map(answer).collect())
    }
}

/// A ray that leaves a point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    /// The triangle's id.
    pub id: u32,
    /// Barycentrics of its second and third corner.
    pub barycentrics: [f32; 2],
    /// Where the point was seen from, a unit vector away from it.
    pub wo: Vec3,
    /// Direction of the ray, or the point on the light that it aims at.
    pub d: Vec3,
    /// The light's id; `NO_INDEX` without one.
    pub light: u32,
}

/// What kind of ray leaves.
#[derive(Clone, Copy, Debug)]
pub enum Leaving {
    /// A ray that extends the path.
    Extension = 0,
    /// A ray to a point on a light.
    Shadow = 1,
    /// A ray that extends the path from the point itself, without an offset.
    Bare = 2,
}

/// Where it started and what it met.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Origin of the ray.
    pub origin: Vec3,
    /// The point that it leaves, from the barycentrics.
    pub point: Vec3,
    /// Id of the triangle that was hit.
    pub hit: Option<u32>,
    /// Key of that hit.
    pub key: f32,
}

/// The trees that there are, over the same triangles.
pub fn trees(triangles: &[Triangle]) -> [(&'static str, Accel); 2] {
    [
        ("wide", WideBvh::build(triangles, Builder::Sah).into()),
        ("binary", BinaryBvh::build(triangles, Builder::Sah).into()),
    ]
}

/// Rays that hit nothing, of those that ought to hit something.
pub fn leaks(what: impl Into<String>, answers: &[Answer]) -> Finding {
    let events = answers.iter().filter(|answer| answer.hit.is_none()).count();
    Finding::never(what, events as u64, answers.len() as u64)
}

/// Rays whose hits differ in a bit of id, key or barycentrics.
pub fn mismatches(what: impl Into<String>, a: &[Answer], b: &[Answer]) -> Finding {
    let events = a.iter().zip(b).filter(|(a, b)| a.bits() != b.bits()).count();
    Finding::never(what, events as u64, a.len().min(b.len()) as u64)
}
