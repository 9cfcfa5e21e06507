//! The example's picture shows lows in blue and highs in orange.

use std::fs::File;
use std::io::BufReader;
use std::process::Command;

#[test]
fn the_picture_shows_highs_and_lows() {
    let path = std::env::temp_dir().join(format!("first-picture-{}.png", std::process::id()));
    let status = Command::new(env!("CARGO_BIN_EXE_first_picture")).arg(&path).status().unwrap();
    assert!(status.success(), "{status}");
    let mut reader = png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    std::fs::remove_file(&path).unwrap();
    let pixels: Vec<&[u8]> = bytes.chunks_exact(info.color_type.samples()).collect();
    assert_eq!((info.width, info.height, pixels.len()), (720, 540, 720 * 540));
    let share = |is: fn(&&&[u8]) -> bool| pixels.iter().filter(is).count() as f64 / pixels.len() as f64;
    let orange = share(|pixel| pixel[0] > pixel[2].saturating_add(40));
    let blue = share(|pixel| pixel[2] > pixel[0].saturating_add(40));
    assert!(orange > 0.06 && blue > 0.06, "{orange} orange, {blue} blue");
}
