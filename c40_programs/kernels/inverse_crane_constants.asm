K_IK_COS_LOW        .set $ - LIFT               ; cos 80 deg: steepest jib
                    .float 0.17364817766693036
K_IK_COS_HIGH       .set $ - LIFT               ; cos 20 deg: flattest
                    .float 0.9396926207859084
