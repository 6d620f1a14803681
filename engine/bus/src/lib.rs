//! Topics, envelopes, publish and subscribe, request and reply
