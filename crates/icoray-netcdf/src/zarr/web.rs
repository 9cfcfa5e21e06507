//! The files of a store on a web server, or parts of them.

use std::time::Duration;
use ureq::Agent;
use ureq::http::{Response, StatusCode};
use zarrs::storage::byte_range::{ByteRange, ByteRangeIterator};
use zarrs::storage::{Bytes, MaybeBytes, MaybeBytesIterator, ReadableStorageTraits, StorageError, StoreKey};

/// Longest wait for a server's answer to begin, and for its end.
const PATIENCE: [Duration; 2] = [Duration::from_secs(30), Duration::from_secs(600)];
/// Largest file of a store.
const MOST_BYTES: u64 = 1 << 36;

/// A store on a web server.
pub(super) struct WebStore {
    address: String,
    agent: Agent,
}

impl WebStore {
    pub fn new(address: &str) -> Self {
        let config = Agent::config_builder()
            .http_status_as_error(false)
            .timeout_connect(Some(PATIENCE[0]))
            .timeout_recv_response(Some(PATIENCE[0]))
            .timeout_recv_body(Some(PATIENCE[1]));
        WebStore { address: address.trim_end_matches('/').to_owned(), agent: config.build().into() }
    }

    /// The bytes of a file, or a range of them, and whether it is the range; `None` where the server has no such file.
    fn request(&self, key: &StoreKey, range: Option<String>) -> Result<Option<(Bytes, bool)>, StorageError> {
        let mut address = format!("{}/{key}", self.address);
        if let Some((path, query)) = self.address.split_once('?') {
            address = format!("{}/{key}?{query}", path.trim_end_matches('/'));
        }
        let error = |what: &dyn std::fmt::Display| StorageError::Other(format!("{address}: {what}"));
        let mut request = self.agent.get(&address);
        if let Some(range) = range {
            request = request.header("Range", range);
        }
        let mut answer: Response<ureq::Body> = request.call().map_err(|e| error(&e))?;
        match answer.status() {
            StatusCode::NOT_FOUND | StatusCode::GONE => Ok(None),
            status if status.is_success() => {
                let bytes = answer.body_mut().with_config().limit(MOST_BYTES).read_to_vec().map_err(|e| error(&e))?;
                Ok(Some((bytes.into(), status == StatusCode::PARTIAL_CONTENT)))
            }
            status => Err(error(&format_args!("the server answers {status}"))),
        }
    }
}

impl ReadableStorageTraits for WebStore {
    fn get(&self, key: &StoreKey) -> Result<MaybeBytes, StorageError> {
        Ok(self.request(key, None)?.map(|(bytes, _)| bytes))
    }

    fn get_partial_many<'a>(
        &'a self,
        key: &StoreKey,
        byte_ranges: ByteRangeIterator<'a>,
    ) -> Result<MaybeBytesIterator<'a>, StorageError> {
        let mut parts = Vec::new();
        for range in byte_ranges {
            let header = match range {
                ByteRange::FromStart(0, None) => None,
                ByteRange::FromStart(start, None) => Some(format!("bytes={start}-")),
                ByteRange::FromStart(start, Some(len)) => Some(format!("bytes={start}-{}", (start + len).max(1) - 1)),
                ByteRange::Suffix(len) => Some(format!("bytes=-{len}")),
            };
            let Some((bytes, is_part)) = self.request(key, header)? else { return Ok(None) };
            let size = bytes.len() as u64;
            // A server may ignore ranges.
            let is_within = range.end(size) <= size && range.start(size) <= range.end(size);
            parts.push(match is_part {
                true => Ok(bytes),
                false if is_within => Ok(bytes.slice(range.to_range_usize(size))),
                false => Err(StorageError::Other(format!("{}/{key}: it ends at byte {size}", self.address))),
            });
        }
        Ok(Some(Box::new(parts.into_iter())))
    }

    fn size_key(&self, key: &StoreKey) -> Result<Option<u64>, StorageError> {
        Ok(self.get(key)?.map(|bytes| bytes.len() as u64))
    }

    fn supports_get_partial(&self) -> bool {
        true
    }
}
