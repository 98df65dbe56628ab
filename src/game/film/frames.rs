//! Writes pictures to files on threads of their own, so that drawing does not wait for them.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex,
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    thread::JoinHandle,
};

use image::{
    ExtendedColorType, ImageEncoder, RgbImage,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

use super::FilmError;

/// Threads that encode.
const THREADS: usize = 2;
/// Pictures that may wait; more would only fill the memory.
const WAITING: usize = 8;

/// Takes pictures and writes them to one folder.
pub struct FrameWriter {
    folder: PathBuf,
    queue: SyncSender<(PathBuf, RgbImage)>,
    threads: Vec<JoinHandle<Result<(), FilmError>>>,
}

impl FrameWriter {
    /// Starts writing into `folder`, which is made if need be. Pictures of an earlier film there are removed.
    ///
    /// # Errors
    /// [`FilmError::File`] if the folder can't be made or cleared.
    pub fn start(folder: &Path) -> Result<Self, FilmError> {
        std::fs::create_dir_all(folder).map_err(|error| FilmError::file(folder, error))?;
        remove_frames(folder)?;
        let (queue, pictures) = sync_channel(WAITING);
        let pictures = Arc::new(Mutex::new(pictures));
        let threads = (0..THREADS)
            .map(|_| {
                let pictures = pictures.clone();
                std::thread::spawn(move || write_all(&pictures))
            })
            .collect();
        Ok(Self { folder: folder.to_path_buf(), queue, threads })
    }

    /// Hands over picture number `frame`. Waits while too many are on their way.
    pub fn write(&self, frame: usize, picture: RgbImage) {
        // Fails only when both threads ended early; `finish` tells why.
        let _ = self.queue.send((self.folder.join(format!("frame_{frame:04}.png")), picture));
    }

    /// Waits for all pictures.
    ///
    /// # Errors
    /// The first thing that went wrong.
    pub fn finish(self) -> Result<(), FilmError> {
        drop(self.queue);
        self.threads.into_iter().try_for_each(|thread| thread.join().unwrap_or(Err(FilmError::Writer)))
    }
}

/// Writes one picture as PNG, lightly packed: half the time of the best packing for a tenth more bytes.
///
/// # Errors
/// [`FilmError::File`] naming the file.
pub fn save(path: &Path, picture: &RgbImage) -> Result<(), FilmError> {
    let file = std::fs::File::create(path).map_err(|error| FilmError::file(path, error))?;
    PngEncoder::new_with_quality(std::io::BufWriter::new(file), CompressionType::Fast, FilterType::Sub)
        .write_image(picture, picture.width(), picture.height(), ExtendedColorType::Rgb8)
        .map_err(|error| FilmError::file(path, error))
}

fn write_all(pictures: &Mutex<Receiver<(PathBuf, RgbImage)>>) -> Result<(), FilmError> {
    loop {
        let next = pictures.lock().map_err(|_| FilmError::Writer)?.recv();
        let Ok((path, picture)) = next else { return Ok(()) };
        save(&path, &picture)?;
    }
}

fn remove_frames(folder: &Path) -> Result<(), FilmError> {
    let entries = std::fs::read_dir(folder).map_err(|error| FilmError::file(folder, error))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let number = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".png"));
        if number.is_some_and(|number| number.len() >= 4 && number.bytes().all(|digit| digit.is_ascii_digit())) {
            std::fs::remove_file(&path).map_err(|error| FilmError::file(&path, error))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_film_removes_the_frames_of_the_last_one_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("surefoot-frames-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for name in ["frame_0007.png", "frame_x.png", "notes.txt"] {
            std::fs::write(folder.join(name), "old").unwrap();
        }
        let writer = FrameWriter::start(&folder).unwrap();
        writer.write(0, RgbImage::new(8, 8));
        writer.finish().unwrap();
        let mut names: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(names, ["frame_0000.png", "frame_x.png", "notes.txt"]);
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let file = std::env::temp_dir().join(format!("surefoot-file-{}", std::process::id()));
        std::fs::write(&file, "").unwrap();
        let error = FrameWriter::start(&file.join("film")).err().map(|error| error.to_string()).unwrap_or_default();
        std::fs::remove_file(&file).unwrap();
        assert!(error.contains("surefoot-file-"), "error does not name the folder: {error}");
    }
}
