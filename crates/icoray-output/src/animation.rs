//! Animated PNG: a sequence of pictures, of which each but the first stores only the differences from the previous one;
//! and MP4 and GIF by ffmpeg.

use super::atomic;
use crate::atomic::Existing;
use crate::folder::io_error;
use crate::label::Canvas;
use icoray_grid::{Error, ErrorKind, Result};
use png::{BitDepth, BlendOp, ColorType, Decoder, DisposeOp, Encoder, Transformations};
use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Stdio};

/// Size, length and bytes of a written animation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Animated {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Number of pictures.
    pub frames: u32,
    /// Bytes of its file.
    pub bytes: u64,
}

/// A part of a picture: its first column and row, its width and height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Region {
    at: [u32; 2],
    size: [u32; 2],
}

/// A format of films that ffmpeg writes.
struct FilmFormat {
    ending: &'static str,
    /// Options of ffmpeg.
    options: &'static [&'static str],
}

/// Sides of an MP4 are even, a GIF has the best 256 colours of its pictures.
const FILMS: [FilmFormat; 2] = [
    FilmFormat {
        ending: "mp4",
        options: &["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart"],
    },
    FilmFormat { ending: "gif", options: &["-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse"] },
];

/// Writes the PNG pictures, all of one size, as an animated PNG to `path`, which repeats at `fps` pictures per second;
/// if `path` ends in `.mp4` or `.gif`, through the program ffmpeg, which must be installed. Pictures are read one by
/// one.
///
/// # Errors
/// [`ErrorKind::Argument`] if there is no picture, if one has another size than the first, if `path` has another
/// extension or is one of the pictures, or if `fps` is not 0.001 to 1000; [`ErrorKind::Io`] if a file cannot be read or
/// written or ffmpeg is missing or fails, [`ErrorKind::Exists`] as specified by [`Existing`].
pub fn write_animation(path: &Path, pictures: &[PathBuf], fps: f64, existing: Existing) -> Result<Animated> {
    let bad = |what: String| Error::new(ErrorKind::Argument, what);
    let [first, rest @ ..] = pictures else { return Err(bad("an animation of no pictures".into())) };
    let film = FILMS.iter().find(|film| path.extension().is_some_and(|ending| ending == film.ending));
    if film.is_none() && path.extension().is_none_or(|ending| ending != "png") {
        return Err(bad(format!("{}: expected a name that ends in .png, .mp4 or .gif", path.display())));
    }
    existing.prepare(path)?;
    let same_file = |picture: &&PathBuf| {
        std::fs::canonicalize(picture).is_ok_and(|picture| std::fs::canonicalize(path).is_ok_and(|p| p == picture))
    };
    if let Some(same) = pictures.iter().find(same_file) {
        return Err(bad(format!("{}: is one of the pictures, expected another file", same.display())));
    }
    let (seconds, parts) =
        delay(fps).ok_or_else(|| bad(format!("{fps} pictures per second, expected 0.001 to 1000")))?;
    let frames = u32::try_from(pictures.len()).map_err(|_| bad(format!("{} pictures", pictures.len())))?;
    let mut shown = read(first)?;
    let size = [shown.width, shown.height];
    let following = |picture: &PathBuf| {
        let next = read(picture)?;
        let [w, h] = [next.width, next.height];
        if [w, h] != size {
            let [first_w, first_h] = size;
            let (path, first) = (picture.display(), first.display());
            let wish = format!("expected all pictures to be as large as {first}, {first_w} x {first_h}");
            return Err(bad(format!("{path}: is {w} x {h} pixels, {wish}")));
        }
        Ok(next)
    };
    let failed = |e: png::EncodingError| io_error(path, "cannot write the animation", e);
    atomic::write(path, existing, "the animation", |out| {
        if let Some(film) = film {
            let pictures = std::iter::once(Ok(shown)).chain(rest.iter().map(following));
            return encode_film(path, film, pictures, size, fps, out);
        }
        let mut encoder = Encoder::new(out, size[0], size[1]);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(frames, 0).map_err(failed)?;
        encoder.set_frame_delay(seconds, parts).map_err(failed)?;
        encoder.set_blend_op(BlendOp::Source).map_err(failed)?;
        encoder.set_dispose_op(DisposeOp::None).map_err(failed)?;
        let software = format!("icoray {}", env!("CARGO_PKG_VERSION"));
        encoder.add_itxt_chunk("Software".into(), software).map_err(failed)?;
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&shown.rgba).map_err(failed)?;
        for path in rest {
            let next = following(path)?;
            let region = differing(&shown, &next);
            // Dimension and position are each checked against the other's current value.
            writer.reset_frame_position().map_err(failed)?;
            writer.set_frame_dimension(region.size[0], region.size[1]).map_err(failed)?;
            writer.set_frame_position(region.at[0], region.at[1]).map_err(failed)?;
            writer.write_image_data(&cut(&next, region)).map_err(failed)?;
            shown = next;
        }
        writer.finish().map_err(failed)
    })?;
    let bytes = path.metadata().map_err(|e| io_error(path, "cannot read the file", e))?.len();
    Ok(Animated { size, frames, bytes })
}

/// Encodes pictures by ffmpeg, first into a file beside the animation, as ffmpeg seeks backwards in its output.
fn encode_film(
    path: &Path,
    FilmFormat { ending, options }: &FilmFormat,
    pictures: impl Iterator<Item = Result<Canvas>>,
    [width, height]: [u32; 2],
    fps: f64,
    out: &mut impl Write,
) -> Result<()> {
    let failed = |e: io::Error| io_error(path, "cannot write the animation", atomic::cause(&e));
    let mut name = tempfile::Builder::new();
    let name =
        name.prefix(".icoray-").suffix(&format!(".{ending}")).tempfile_in(atomic::folder(path)).map_err(failed)?;
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba", "-s", &format!("{width}x{height}")]);
    ffmpeg.args(["-r", &fps.to_string(), "-i", "-"]).args(*options).arg(name.path());
    let mut ffmpeg =
        ffmpeg.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(|e| {
            let wish =
                format!("expected the program ffmpeg for .{ending}: install it, or take a name that ends in .png");
            io_error(path, &wish, e)
        })?;
    let feed = |mut input: ChildStdin| -> Result<()> {
        for picture in pictures {
            // ffmpeg prints the reason for an early end.
            if input.write_all(&picture?.rgba).is_err() {
                break;
            }
        }
        Ok(())
    };
    let fed = ffmpeg.stdin.take().map_or(Ok(()), feed);
    let ended = ffmpeg.wait_with_output().map_err(failed)?;
    fed?;
    if !ended.status.success() {
        let errors = String::from_utf8_lossy(&ended.stderr);
        return Err(io_error(path, "ffmpeg cannot write it", errors.lines().last().unwrap_or("it gives no reason")));
    }
    io::copy(&mut File::open(name.path()).map_err(failed)?, out).map(drop).map_err(failed)
}

/// Seconds for which a picture is shown, as a fraction.
fn delay(fps: f64) -> Option<(u16, u16)> {
    // Whole numbers of pictures per second exactly, others to a millisecond or a part in sixty.
    if fps.fract() == 0.0 && (1.0..=1000.0).contains(&fps) {
        return Some((1, fps as u16));
    }
    let parts = if fps < 0.1 { 60.0 } else { 1000.0 };
    (1e-3..=1e3).contains(&fps).then(|| ((parts / fps).round() as u16, parts as u16))
}

/// The picture in a file.
fn read(path: &Path) -> Result<Canvas> {
    let failed = |e: png::DecodingError| io_error(path, "cannot read the picture", e);
    let file = File::open(path).map_err(|e| io_error(path, "cannot read the picture", e))?;
    let mut decoder = Decoder::new(BufReader::new(file));
    decoder.set_transformations(Transformations::normalize_to_color8() | Transformations::ALPHA);
    let mut reader = decoder.read_info().map_err(failed)?;
    let size = reader.output_buffer_size();
    let mut bytes = vec![0; size.ok_or_else(|| io_error(path, "cannot read the picture", "it is too large"))?];
    let info = reader.next_frame(&mut bytes).map_err(failed)?;
    bytes.truncate(info.buffer_size());
    let rgba = match info.color_type {
        ColorType::GrayscaleAlpha => {
            bytes.chunks(2).flat_map(|pixel| [pixel[0], pixel[0], pixel[0], pixel[1]]).collect()
        }
        _ => bytes,
    };
    Ok(Canvas { width: info.width, height: info.height, rgba })
}

/// The bytes of a region.
fn cut(picture: &Canvas, Region { at: [x, y], size: [width, height] }: Region) -> Vec<u8> {
    let rows = (y..y + height).flat_map(|y| {
        let at = 4 * (y as usize * picture.width as usize + x as usize);
        &picture.rgba[at..at + 4 * width as usize]
    });
    rows.copied().collect()
}

/// The smallest region that contains all differences of two pictures of one size; one pixel if they are equal.
fn differing(a: &Canvas, b: &Canvas) -> Region {
    let (mut low, mut high) = ([a.width, a.height], [0, 0]);
    let pixels = (0..).zip(a.rgba.as_chunks::<4>().0.iter().zip(b.rgba.as_chunks().0));
    for (at, _) in pixels.filter(|(_, (a, b))| a != b) {
        let (x, y) = (at % a.width, at / a.width);
        low = [low[0].min(x), low[1].min(y)];
        high = [high[0].max(x), high[1].max(y)];
    }
    if low[0] > high[0] {
        return Region { at: [0, 0], size: [1, 1] };
    }
    Region { at: low, size: [high[0] - low[0] + 1, high[1] - low[1] + 1] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png_file::write_canvas;

    /// A picture of 5 x 4 pixels, gradients with a dot in it.
    fn picture(folder: &Path, name: &str, dot: [u32; 2]) -> PathBuf {
        let mut rgba: Vec<u8> = (0..20u8).flat_map(|i| [i, 10 * i, 255 - i, 250 + i % 5]).collect();
        let at = 4 * (dot[1] * 5 + dot[0]) as usize;
        rgba[at..at + 4].fill(200);
        let path = folder.join(name);
        write_canvas(&path, &Canvas { width: 5, height: 4, rgba }, &[], Existing::Overwrite).unwrap();
        path
    }

    /// The frames of an animation as a viewer shows them, and how long each is shown.
    fn frames(path: &Path) -> Vec<(Vec<u8>, (u16, u16))> {
        let mut reader = Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        let [width, height] = [reader.info().width as usize, reader.info().height as usize];
        let count = reader.info().animation_control.unwrap();
        assert_eq!(count.num_plays, 0);
        let mut canvas = vec![0; 4 * width * height];
        let mut frames = Vec::new();
        for _ in 0..count.num_frames {
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut bytes).unwrap();
            let control = *reader.info().frame_control().unwrap();
            assert_eq!((control.blend_op, control.dispose_op), (BlendOp::Source, DisposeOp::None));
            let row = 4 * control.width as usize;
            for y in 0..control.height as usize {
                let at = 4 * ((control.y_offset as usize + y) * width + control.x_offset as usize);
                canvas[at..at + row].copy_from_slice(&bytes[y * row..(y + 1) * row]);
            }
            frames.push((canvas.clone(), (control.delay_num, control.delay_den)));
        }
        frames
    }

    #[test]
    fn its_frames_are_the_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let dots = [[0, 0], [1, 0], [4, 3], [4, 3], [2, 2], [0, 0]];
        let pictures: Vec<PathBuf> = (0..6).map(|i| picture(folder.path(), &format!("{i}.png"), dots[i])).collect();
        let path = folder.path().join("movie.png");
        for (fps, delay) in [(10.0, (1, 10)), (2.5, (400, 1000)), (0.001, (60_000, 60)), (1000.0, (1, 1000))] {
            let made = write_animation(&path, &pictures, fps, Existing::Overwrite).unwrap();
            let bytes = path.metadata().unwrap().len();
            assert_eq!(made, Animated { size: [5, 4], frames: 6, bytes });
            let frames = frames(&path);
            assert_eq!(frames.len(), 6);
            for (frame, picture) in frames.iter().zip(&pictures) {
                assert_eq!(frame.1, delay);
                assert_eq!(frame.0, read(picture).unwrap().rgba, "{}", picture.display());
            }
        }
        let parts = [
            differing(&read(&pictures[0]).unwrap(), &read(&pictures[1]).unwrap()),
            differing(&read(&pictures[2]).unwrap(), &read(&pictures[3]).unwrap()),
        ];
        assert_eq!(parts, [Region { at: [0, 0], size: [2, 1] }, Region { at: [0, 0], size: [1, 1] }]);
        // A viewer without support for animations shows the first picture.
        assert_eq!(image::open(&path).unwrap().to_rgba8().into_raw(), read(&pictures[0]).unwrap().rgba);
    }

    #[test]
    fn pictures_that_cannot_be_animated_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let first = picture(folder.path(), "a.png", [0, 0]);
        let other = Canvas { width: 2, height: 3, rgba: vec![9; 24] };
        write_canvas(&at("b.png"), &other, &[], Existing::Overwrite).unwrap();
        std::fs::write(at("c.png"), "no picture").unwrap();
        let both = |name: &str| vec![first.clone(), at(name)];
        for (path, pictures, fps, kind, part) in [
            ("m.png", vec![], 10.0, ErrorKind::Argument, "no pictures"),
            ("m.avi", both("a.png"), 10.0, ErrorKind::Argument, "ends in .png, .mp4 or .gif"),
            ("m.png", both("a.png"), 0.0, ErrorKind::Argument, "0 pictures per second, expected 0.001"),
            ("m.png", both("a.png"), f64::NAN, ErrorKind::Argument, "NaN pictures"),
            ("a.png", both("a.png"), 10.0, ErrorKind::Argument, "is one of the pictures"),
            ("a.png/m.png", both("a.png"), 10.0, ErrorKind::Io, "cannot write the file: Not a directory"),
            ("m.png", both("b.png"), 10.0, ErrorKind::Argument, "b.png: is 2 x 3 pixels, expected"),
            ("m.png", both("c.png"), 10.0, ErrorKind::Io, "c.png: cannot read the picture"),
            ("m.png", both("d.png"), 10.0, ErrorKind::Io, "d.png: cannot read the picture"),
        ] {
            let error = write_animation(&at(path), &pictures, fps, Existing::Overwrite).unwrap_err();
            assert!(error.kind() == kind && error.to_string().contains(part), "{error}");
            assert!(!at("m.png").exists(), "nothing is left of what fails");
        }
        std::fs::write(at("m.png"), "mine").unwrap();
        let error = write_animation(&at("m.png"), &both("a.png"), 10.0, Existing::NeverModify).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Exists);
    }
}
