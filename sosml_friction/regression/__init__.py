# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings to rows: band, noise, rests, whitening, and the columns of every term."""
