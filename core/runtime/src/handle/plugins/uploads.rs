//! Libraries taken over the API: off until somebody enables them, and only where the configuration names a folder for them.

use super::super::NodeHandle;
use super::PluginRefusal;
use skein_domain::exchange::Severity;
use std::path::PathBuf;

impl NodeHandle {
    /// Keeps an uploaded library, switched off.
    ///
    /// # Errors
    /// When the configuration takes no uploads, the name is none of a library, or it cannot be written.
    pub fn keep_upload(&self, file: &str, bytes: &[u8]) -> Result<(), PluginRefusal> {
        let path = self.upload_path(file)?;
        let off = path.with_extension("so.off");
        let partly = path.with_extension("so.part");
        // Renamed when it is whole, so that nobody ever enables half a library.
        std::fs::write(&partly, bytes)
            .and_then(|()| std::fs::rename(&partly, &off))
            .map_err(|e| PluginRefusal::BadUpload { detail: e.to_string() })?;
        self.tell(
            file,
            Severity::Advisory,
            format!("{file} was uploaded; it is off until it is enabled"),
        );
        Ok(())
    }

    /// Switches an uploaded library on: the next look at the directories finds it.
    ///
    /// # Errors
    /// As [`Self::keep_upload`], and when there is no such upload.
    pub fn enable_upload(&self, file: &str) -> Result<(), PluginRefusal> {
        let path = self.upload_path(file)?;
        std::fs::rename(path.with_extension("so.off"), &path).map_err(|e| PluginRefusal::BadUpload {
            detail: format!("{file} cannot be enabled: {e}"),
        })
    }

    fn upload_path(&self, file: &str) -> Result<PathBuf, PluginRefusal> {
        let Some(directory) = &self.shared.config.plugins.upload_directory else {
            return Err(PluginRefusal::NotPermitted {
                detail: "this node takes no uploads (plugins.upload_directory)".into(),
            });
        };
        let stem = file.strip_prefix("lib").and_then(|rest| rest.strip_suffix(".so"));
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if !stem.is_some_and(|stem| !stem.is_empty() && stem.len() <= 64 && stem.chars().all(letter)) {
            return Err(PluginRefusal::BadUpload {
                detail: format!("{file:?} is not the name of a library, such as libgimbal_plugin.so"),
            });
        }
        Ok(directory.join(file))
    }
}
