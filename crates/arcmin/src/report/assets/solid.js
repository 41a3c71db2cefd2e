// Names of the scene scripts (in a separate scope) that figures use.
return { View, ringWords, capital, pitchFrameAt, largest, ArmView, postureOf, wayOf, reachedWay, momentAt, readAt, magnificationAt, ballAround, gridStep };
