//! Scenes of the Mitsuba 3 renderer: XML of scene version 3.
