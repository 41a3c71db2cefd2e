// Of the scripts of a scene, which stand in a scope of their own, the names that figures use.
return { View, ringWords, capital, pitchFrameAt, largest, ArmView, postureOf, wayOf, reachedWay, momentAt, readAt, magnificationAt, ballAround, gridStep };
