//! Rung 2: what the host packs is what the shader's fetch functions read, word for word.
//!
//! Every record kind of scenes of the repository goes up as texels and as storage buffers, is read by its own fetch function
//! (`glsl/probe_layout.comp`), and comes back field by field; the fields are compared with what the host holds before
//! packing, not with the packed texels alone. All comparisons are exact.

mod harness;

use harness::device::load;
use harness::device::run_probe;
use harness::probe::Probe;
use texray::bvh::{Accel, BinaryBvh, Builder, WideBvh};
use texray::gpu::shaders;
use texray::interface::*;
use texray::scene::Scene;
use texray::settings::{Buffers, LightPick, Settings};
use texray::texels::light::build_lights;
use texray::texels::light_cone::decode_octahedral;
use texray::texels::{Texel, TexelData, camera, triangle};

/// Texels that the probe writes a record.
const FIELDS: usize = 8;

fn fetched(scene: &Scene, accel: &Accel, buffers: Buffers, binding: u32, count: usize) -> Vec<[Texel; FIELDS]> {
    let data = TexelData::pack(scene, accel, &Settings::for_scene(scene)).expect("the scene can be packed");
    let probe = Probe {
        module: shaders::PROBE_LAYOUT,
        data: &data,
        accel,
        buffers,
        specialization: Vec::new(),
        function: binding,
        first_sample: 0,
        calls: count as u32,
        input: &[],
        output_texels: FIELDS as u32,
        without_guard: None,
    };
    let texels = run_probe(&probe);
    let (records, rest) = texels.as_chunks::<FIELDS>();
    assert!(rest.is_empty() && records.len() == count, "as many records as asked for");
    records.to_vec()
}

/// Eight texels of which the first are given.
fn padded(first: &[Texel]) -> [Texel; FIELDS] {
    std::array::from_fn(|i| first.get(i).copied().unwrap_or_default())
}

/// Checks a record kind, both ways of binding it. An empty kind would prove nothing.
fn check(scene: &Scene, accel: &Accel, binding: u32, expected: &[[Texel; FIELDS]], what: &str) {
    assert!(!expected.is_empty(), "{what}: there is none");
    for buffers in [Buffers::Texel, Buffers::Storage] {
        let found = fetched(scene, accel, buffers, binding, expected.len());
        if let Some(i) = found.iter().zip(expected).position(|(found, expected)| found != expected) {
            panic!("{what} {i} in {buffers:?} buffers: {:08x?} is not {:08x?}", found[i], expected[i]);
        }
    }
}

fn word([x, y, z]: [f32; 3], w: u32) -> Texel {
    [x.to_bits(), y.to_bits(), z.to_bits(), w]
}

fn trees(scene: &Scene) -> [Accel; 3] {
    let binary = BinaryBvh::build(&scene.triangles, Builder::Sah);
    let wide = WideBvh::build(&scene.triangles, Builder::Sah);
    [Accel::brute(), binary.into(), wide.into()]
}

/// The scene with every kind of record: smooth triangles, several materials, lights, a filter's table.
fn scene() -> Scene {
    let scene = load("teapot");
    assert!(!scene.corners.is_empty() && scene.film.filter != texray::scene::Filter::Box);
    scene
}

#[test]
fn nodes_of_both_trees() {
    let scene = scene();
    for accel in trees(&scene) {
        let expected: Vec<_> = match &accel {
            Accel::Brute => continue,
            Accel::Binary(tree) => {
                let record = |node: &texray::bvh::BinaryNode| {
                    let bounds = node.bounds;
                    padded(&[word(bounds.low.to_array(), node.first), word(bounds.high.to_array(), node.count)])
                };
                tree.nodes.iter().map(record).collect()
            }
            Accel::Wide(tree) => tree.nodes.iter().map(wide_fields).collect(),
        };
        check(&scene, &accel, BINDING_NODES, &expected, "node");
    }
}

/// The fields of `WideNode` in `glsl/records/node.glsl`, from the node itself.
fn wide_fields(node: &texray::bvh::WideNode) -> [Texel; FIELDS] {
    let pair = |bytes: [u8; 8]| {
        let word = |i: usize| u32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * i + byte]));
        [word(0), word(1)]
    };
    let four = |a: [u8; 8], b: [u8; 8]| [pair(a)[0], pair(a)[1], pair(b)[0], pair(b)[1]];
    let [x, y, z] = node.origin;
    let [ex, ey, ez] = node.exponent.map(|exponent| u32::from(exponent) << 23);
    padded(&[
        [x, y, z, u32::from(node.inner_mask)],
        [ex, ey, ez, 0],
        [node.first_child, node.first_triangle, pair(node.meta)[0], pair(node.meta)[1]],
        four(node.low[0], node.low[1]),
        four(node.low[2], node.high[0]),
        four(node.high[1], node.high[2]),
    ])
}

#[test]
fn triangles_surfaces_and_corners_in_leaf_order() {
    let scene = scene();
    for accel in trees(&scene) {
        let order = accel.order(scene.triangles.len());
        let in_order = || order.iter().map(|&id| (id, &scene.triangles[id as usize]));
        // How densities come about is held against what is drawn in tests/warps.rs.
        let densities = build_lights(&scene, &order, LightPick::Power).expect("few lights").pdf_area;
        let emits = |id: &usize| scene.materials[scene.triangles[*id].material as usize].emits();
        assert!(densities.iter().enumerate().all(|(id, &density)| (density > 0.0) == emits(&id)));
        assert!(densities.iter().any(|&density| density > 0.0));
        let triangles: Vec<_> = in_order()
            .map(|(id, triangle)| {
                let density = densities[id as usize];
                let emits = if density > 0.0 { TRIANGLE_EMITS } else { 0 };
                let smooth = if triangle.corners == NO_INDEX { 0 } else { TRIANGLE_SMOOTH };
                let [v0, v1, v2] = triangle.positions.map(|position| position.to_array());
                padded(&[word(v0, id), word(v1, emits | smooth), word(v2, density.to_bits())])
            })
            .collect();
        check(&scene, &accel, BINDING_TRIANGLES, &triangles, "triangle");
        let surfaces: Vec<_> = in_order()
            .map(|(_, triangle)| {
                let normal = triangle::geometric_normal(triangle).as_vec3().to_array();
                padded(&[word(normal, triangle.material)])
            })
            .collect();
        check(&scene, &accel, BINDING_SURFACES, &surfaces, "surface");
        let corners: Vec<_> = in_order()
            .map(|(_, triangle)| match scene.corners.get(triangle.corners as usize) {
                None => padded(&[]),
                Some(corners) => {
                    let [n0, n1, n2] = corners.normals.map(|normal| word(normal.to_array(), 0));
                    let [a, b, c] = corners.uvs.map(|uv| [uv.x.to_bits(), uv.y.to_bits()]);
                    padded(&[n0, n1, n2, [a[0], a[1], b[0], b[1]], [c[0], c[1], 0, 0]])
                }
            })
            .collect();
        check(&scene, &accel, BINDING_CORNERS, &corners, "corners");
    }
}

#[test]
fn materials_of_every_kind() {
    use texray::scene::MaterialKind;
    for (name, kind) in
        [("cornell-box", MATERIAL_LAMBERT), ("cornell-mirror", MATERIAL_MIRROR), ("cornell-glass", MATERIAL_GLASS)]
    {
        let scene = load(name);
        let record = |material: &texray::scene::Material| {
            let (kind, ior, reflectance) = match material.kind {
                MaterialKind::Lambert { albedo } => (MATERIAL_LAMBERT, 1.0, albedo),
                MaterialKind::Mirror { reflectance } => (MATERIAL_MIRROR, 1.0, reflectance),
                MaterialKind::Glass { ior } => (MATERIAL_GLASS, ior, [1.0f32; 3]),
            };
            padded(&[word(reflectance, kind), word(material.emission, f32::to_bits(ior))])
        };
        let expected: Vec<_> = scene.materials.iter().map(record).collect();
        assert!(expected.iter().any(|record| record[0][3] == kind), "{name} has no such material");
        check(&scene, &Accel::brute(), BINDING_MATERIALS, &expected, "material");
    }
}

#[test]
fn lights_the_camera_and_the_filter() {
    let scene = scene();
    let settings = Settings::for_scene(&scene);
    let accel = Accel::brute();
    let data = TexelData::pack(&scene, &accel, &settings).expect("the scene can be packed");
    // Without a tree leaf order is file order; the probabilities are held against each other in tests/sampling.rs.
    let emitters: Vec<u32> = (0..scene.triangles.len() as u32)
        .filter(|&id| scene.materials[scene.triangles[id as usize].material as usize].emits())
        .collect();
    let packed = data.lights.as_chunks::<5>().0;
    assert_eq!(packed.len(), emitters.len());
    let mut begin = 0u32;
    let lights: Vec<_> = emitters
        .iter()
        .zip(packed)
        .map(|(&id, packed)| {
            let triangle = &scene.triangles[id as usize];
            let [v0, v1, v2] = triangle.positions.map(|position| position.to_array());
            let normal = triangle::geometric_normal(triangle).as_vec3().to_array();
            let emission = scene.materials[triangle.material as usize].emission;
            let (end, density) = (packed[0][3], packed[2][3]);
            let scale = (1.0 / (u64::from(end) - u64::from(begin) + 1) as f32).to_bits();
            let lit = [word(normal, begin), word(emission, scale)];
            begin = end.wrapping_add(1);
            padded(&[word(v0, end), word(v1, id), word(v2, density), lit[0], lit[1], [end, 0, 0, 0]])
        })
        .collect();
    check(&scene, &accel, BINDING_LIGHTS, &lights, "light");

    let basis = scene.camera.basis(settings.height);
    let [origin, forward, right, down] =
        [scene.camera.origin, basis.forward, basis.right, basis.down].map(|v| v.as_vec3().to_array());
    let size = [settings.width as f32, settings.height as f32].map(f32::to_bits);
    let fields = padded(&[word(origin, FILTER_TABLE), word(forward, size[0]), word(right, size[1]), word(down, 0)]);
    check(&scene, &accel, BINDING_CAMERA, &[fields], "camera");

    let table = camera::filter_texels(settings.filter);
    let entries: Vec<_> = table.iter().flatten().map(|&entry| padded(&[[entry, 0, 0, 0]])).collect();
    assert_eq!(entries.len(), FILTER_ENTRIES as usize);
    check(&scene, &accel, BINDING_FILTER, &entries, "filter entry");
}

/// Clusters of the light tree, each a record here; what they mean is held against the lights in `src/texels/light_tree.rs`.
#[test]
fn clusters_of_the_light_tree() {
    let mut scene = scene();
    scene.materials.iter_mut().for_each(|material| material.emission = [1.0; 3]);
    let settings = Settings::for_scene(&scene);
    assert_eq!(settings.light_pick, LightPick::Tree);
    let data = TexelData::pack(&scene, &Accel::brute(), &settings).expect("the scene can be packed");
    let clusters: Vec<_> = data
        .light_nodes
        .as_chunks::<2>()
        .0
        .iter()
        .map(|&[[x, y, z, spread], [_, power, child, count]]| {
            let cosine = f64::from(spread & 0xffff) / 32_767.5 - 1.0;
            padded(&[[x, y, z, spread & 0xffff_0000], [0, 0, 0, (cosine as f32).to_bits()], [power, child, count, 0]])
        })
        .collect();
    assert!(clusters.len() > 1000);
    for buffers in [Buffers::Texel, Buffers::Storage] {
        let found = fetched(&scene, &Accel::brute(), buffers, BINDING_LIGHT_NODES, clusters.len());
        for (i, (found, expected)) in found.iter().zip(&clusters).enumerate() {
            assert_eq!([found[0], found[2]], [expected[0], expected[2]], "cluster {i}");
            // Decoded with a few roundings: the axis within 1e-6, the cosine within one of 2^-24.
            let near = |a: u32, b: f64, most: f64| (f64::from(f32::from_bits(a)) - b).abs() <= most;
            assert!(near(found[1][3], f64::from(f32::from_bits(expected[1][3])), 1.2e-7), "cosine of {i}");
            let axis = decode_octahedral(data.light_nodes[2 * i + 1][0]).to_array();
            assert!((0..3).all(|lane| near(found[1][lane], axis[lane], 1e-6)), "axis of {i}");
        }
    }
}

/// A float that holds an integer's bits may be flushed or made quiet on its way: lanes are integers, so nothing is.
#[test]
fn odd_bit_patterns_survive() {
    let scene = scene();
    let mut odd = scene.clone();
    let patterns = [0x0000_0001, 0x807f_ffff, 0x7f80_0001, 0xffc0_0000, 0x8000_0000, 0x7f80_0000].map(f32::from_bits);
    for (i, material) in odd.materials.iter_mut().enumerate() {
        // Not emission: a scene of such lights has no probabilities.
        let albedo = std::array::from_fn(|channel| patterns[(3 * i + channel) % patterns.len()]);
        material.kind = texray::scene::MaterialKind::Lambert { albedo };
    }
    let record = |material: &texray::scene::Material| {
        let texray::scene::MaterialKind::Lambert { albedo } = material.kind else { unreachable!("all are Lambert") };
        padded(&[word(albedo, MATERIAL_LAMBERT), word(material.emission, 1f32.to_bits())])
    };
    let expected: Vec<_> = odd.materials.iter().map(record).collect();
    assert!(expected.len() * 3 >= patterns.len());
    check(&odd, &Accel::brute(), BINDING_MATERIALS, &expected, "material of odd bits");
}

#[test]
fn constants_of_a_render() {
    let scene = scene();
    let data = TexelData::pack(&scene, &Accel::brute(), &Settings::for_scene(&scene)).expect("the scene can be packed");
    let (triangles, lights) = (data.triangle_count, data.light_count);
    let expected = padded(&[
        [0.25f32, 0.5, 0.75, 1.0].map(f32::to_bits),
        [triangles, lights, 8, 0x1234_5678],
        [0x9abc_def0, 0, 0, 0],
    ]);
    check(&scene, &Accel::brute(), RECORD_BINDINGS, &[expected], "the constants");
}
