uniform vec3 u_sun;      // towards the sun whose shadows the relief has
uniform vec3 u_up;       // away from the zero surface, at the eye
uniform vec2 u_heights;  // lowest, highest ground
