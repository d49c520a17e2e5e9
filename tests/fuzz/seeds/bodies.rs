//! Good meshes and volumes, small ones.

use super::kept::solved;
use crate::readers::command;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::path::Path;

/// An octahedron.
const POINTS: [[f32; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
];
const FACES: [[u8; 3]; 8] = [
    [0, 2, 4],
    [2, 1, 4],
    [1, 3, 4],
    [3, 0, 4],
    [2, 0, 5],
    [1, 2, 5],
    [3, 1, 5],
    [0, 3, 5],
];

fn points() -> impl Iterator<Item = f32> {
    POINTS.into_iter().flatten()
}

/// Wavefront OBJ, with faces of three and of four corners, written in each way.
pub fn objs(_: &Path) -> Vec<Vec<u8>> {
    let vertex = |[x, y, z]: [f32; 3]| format!("v {x} {y} {z}\n");
    let corners: String = POINTS.map(vertex).concat();
    let face = |[a, b, c]: [u8; 3]| format!("f {} {}/1 {}//1\n", a + 1, b + 1, c + 1);
    let all = format!("# body\no a\n{corners}{}", FACES.map(face).concat());
    let others = format!("{corners}f -6 -4 -2 -3\nf 1 3 2 4 \\\n 5\nf 1 6 2\n");
    vec![all.into_bytes(), others.into_bytes()]
}

/// STL, binary and in words.
pub fn stls(_: &Path) -> Vec<Vec<u8>> {
    let mut binary = vec![b' '; 80];
    binary.extend((FACES.len() as u32).to_le_bytes());
    let mut words = String::from("solid a\n");
    for face in FACES {
        binary.extend([0; 12]);
        words.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in face.map(|corner| POINTS[usize::from(corner)]) {
            binary.extend([x, y, z].iter().flat_map(|x| x.to_le_bytes()));
            words.push_str(&format!("vertex {x:e} {y:e} {z:e}\n"));
        }
        binary.extend([0; 2]);
        words.push_str("endloop\nendfacet\n");
    }
    words.push_str("endsolid a\n");
    vec![binary, words.into_bytes()]
}

/// PLY, in words and of either order of bytes.
pub fn plys(_: &Path) -> Vec<Vec<u8>> {
    let head = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment a\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            POINTS.len(),
            FACES.len()
        )
    };
    let mut words = head("ascii");
    words.extend(POINTS.map(|[x, y, z]| format!("{x} {y} {z}\n")));
    words.extend(FACES.map(|[a, b, c]| format!("3 {a} {b} {c}\n")));
    let mut little = head("binary_little_endian").into_bytes();
    little.extend(points().flat_map(f32::to_le_bytes));
    let mut big = head("binary_big_endian").into_bytes();
    big.extend(points().flat_map(f32::to_be_bytes));
    for face in FACES {
        little.push(3);
        little.extend(face.iter().flat_map(|&corner| i32::from(corner).to_le_bytes()));
        big.push(3);
        big.extend(face.iter().flat_map(|&corner| i32::from(corner).to_be_bytes()));
    }
    vec![words.into_bytes(), little, big]
}

/// The text of a glTF around the key of its buffer, and the buffer.
fn scene(buffer: &dyn Fn(&[u8]) -> String) -> (String, Vec<u8>) {
    let mut bytes: Vec<u8> = points().flat_map(f32::to_le_bytes).collect();
    let split = bytes.len();
    bytes.extend(FACES.iter().flatten());
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\
         \"nodes\":[{{\"children\":[1,2],\"rotation\":[-0.7,0,0,0.7]}},{{\"mesh\":0,\"scale\":[0.5,0.5,0.5]}},{{\"mesh\":0,\"translation\":[1,0,0]}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"indices\":1}},{{\"attributes\":{{\"POSITION\":0}},\"indices\":1,\"mode\":5}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":{},\"type\":\"VEC3\"}},\
         {{\"bufferView\":1,\"componentType\":5121,\"count\":{},\"type\":\"SCALAR\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{split}}},{{\"buffer\":0,\"byteOffset\":{split},\"byteLength\":{}}}],\
         \"buffers\":[{{{}\"byteLength\":{}}}]}}",
        POINTS.len(),
        3 * FACES.len(),
        bytes.len() - split,
        buffer(&bytes),
        bytes.len()
    );
    (text, bytes)
}

/// glTF that holds its buffer itself.
pub fn gltfs(_: &Path) -> Vec<Vec<u8>> {
    let held = |bytes: &[u8]| {
        let text = STANDARD.encode(bytes);
        format!("\"uri\":\"data:application/octet-stream;base64,{text}\",")
    };
    vec![scene(&held).0.into_bytes()]
}

/// glTF in one file of bytes.
pub fn glbs(_: &Path) -> Vec<Vec<u8>> {
    let (text, buffer) = scene(&|_| String::new());
    let text = format!("{text:<width$}", width = text.len().next_multiple_of(4));
    let word = |count: usize| (count as u32).to_le_bytes();
    let parts: [&[u8]; 8] = [
        b"glTF\x02\0\0\0",
        &word(28 + text.len() + buffer.len()),
        &word(text.len()),
        b"JSON",
        text.as_bytes(),
        &word(buffer.len()),
        b"BIN\0",
        &buffer,
    ];
    vec![parts.concat()]
}

/// Volumes that OpenVDB wrote, and those of a result, packed in each way.
pub fn volumes(work: &Path) -> Vec<Vec<u8>> {
    let given = ["blosc_float", "blosc_half", "level_set"];
    let read =
        |name: &str| std::fs::read(format!("{}/tests/program/volumes/{name}.vdb", super::ROOT)).unwrap();
    let mut files = given.map(read).to_vec();
    let done = solved(work);
    for (packing, precision) in [
        ("zip", "half"),
        ("zip", "float"),
        ("none", "half"),
        ("none", "float"),
    ] {
        let out = work.join(format!("volume_{packing}_{precision}"));
        let [done, out] = [&done, &out].map(|path| path.to_str().unwrap());
        let export = [
            "export", done, "--quiet", "--format", "vdb", "--steps", "0", "-o", out,
        ];
        let manner = ["--compression", packing, "--precision", precision];
        command(&[&export[..], &manner].concat()).unwrap();
        let mut volumes = std::fs::read_dir(Path::new(out).join("vdb")).unwrap();
        let volume = volumes.next().unwrap().unwrap().path();
        files.push(std::fs::read(volume).unwrap());
    }
    files
}

/// What elastic bodies are held by, beside their mesh.
fn held(work: &Path, name: &str, file: &str, dims: usize) {
    let [least, most] = [-9.0, 0.1].map(|x| vec![x; dims]);
    let most = [&most[..1], &vec![9.0; dims - 1]].concat();
    let text = format!(
        "mesh = {{ file = \"{file}\" }}\nhold = [{{ box = {{ min = {least:?}, max = {most:?} }} }}]\n[solver]\nmethods = [\"newton\", \"cc\"]\n"
    );
    std::fs::write(work.join(name), text).unwrap();
}

/// A flat mesh.
pub fn flat_objs(work: &Path) -> Vec<Vec<u8>> {
    held(work, "obj.toml", "m.obj", 2);
    let text = "# flat\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1/1/1 3//1 -2\nf 2 5 3\n";
    vec![text.as_bytes().to_vec()]
}

/// Gmsh's files, of both versions; triangles, and tetrahedra in a plane.
pub fn mshs(work: &Path) -> Vec<Vec<u8>> {
    held(work, "msh.toml", "m.msh", 2);
    let older = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n7 2 0 0\n$EndNodes\n\
                 $Elements\n5\n1 15 2 0 1 1\n2 1 2 0 1 1 2\n3 2 2 0 1 1 2 3\n4 2 2 0 1 1 3 4\n5 2 2 0 1 2 7 3\n$EndElements\n";
    let newer = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n2 5 1 7\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 1 0 1\n7\n2 0 0\n$EndNodes\n\
                 $Elements\n2 4 1 4\n1 1 1 1\n1 1 2\n2 1 2 3\n2 1 2 3\n3 1 3 4\n4 2 7 3\n$EndElements\n";
    [older, newer].map(|text| text.as_bytes().to_vec()).to_vec()
}
